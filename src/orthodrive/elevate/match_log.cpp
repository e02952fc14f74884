#include "orthodrive/elevate/match_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <tuple>

#include "orthodrive/geo/line_grid.hpp"

namespace orthodrive {
namespace {

constexpr double backwards_m = 5.0;        // noise may put a pose behind the one before
constexpr double longest_detour_m = 40.0;  // a way on roads that is longer than the straight one by more is none
constexpr double leave_road_log = -6.0;    // ln of the probability to leave roads, or to come back, between two poses
constexpr double impossible = -1e300;

/// A place on a road, driven in one direction.
struct Candidate {
  std::size_t path = 0;
  double s_m = 0.0, offset_m = 0.0;
  bool forward = true;
  double log_emission = 0.0;
};

/// Part of a path on the way from one matched pose to the next; s_to < s_from against the path's direction.
struct Piece {
  std::size_t path;
  double s_from, s_to;
};

struct Keyframe {
  std::size_t pose = 0;
  std::vector<Candidate> candidates;
};

double wrapped(double angle) { return std::remainder(angle, 2.0 * M_PI); }

/// The place on a path nearest to p among the parts between two s.
LogPlace project_between(const RoadPath& path, double s_low, double s_high, Vec2 p, double& distance_m) {
  const auto& nodes = path.nodes;
  auto at = std::upper_bound(nodes.begin(), nodes.end(), s_low, [](double s, const RoadNode& n) { return s < n.s_m; });
  std::size_t i = at == nodes.begin() ? 0 : static_cast<std::size_t>(at - nodes.begin()) - 1;
  LogPlace best;
  distance_m = std::numeric_limits<double>::infinity();
  for (; i + 1 < nodes.size() && (nodes[i].s_m <= s_high || distance_m == std::numeric_limits<double>::infinity());
       ++i) {
    const RoadNode &a = nodes[i], &b = nodes[i + 1];
    const double run = b.s_m - a.s_m;
    if (!(run > 0.0)) continue;
    const Vec2 d = b.p - a.p;
    const double n2 = std::max(1e-12, dot(d, d));
    const double low = std::clamp((s_low - a.s_m) / run, 0.0, 1.0), high = std::clamp((s_high - a.s_m) / run, low, 1.0);
    const double f = std::clamp(dot(p - a.p, d) / n2, low, high);
    const double far = distance(p, a.p + d * f);
    if (far < distance_m) {
      distance_m = far;
      best.s_m = a.s_m + f * run, best.offset_m = cross(d, p - a.p) / std::sqrt(n2);
    }
  }
  return best;
}

}  // namespace

struct LogMatcher::Graph {
  /// Where a path meets others.
  struct Stop {
    double s_m;
    std::size_t vertex;
  };
  struct Visit {
    std::size_t path, stop;  ///< index in stops[path]
  };
  LineGrid grid;
  std::vector<Polyline> lines;
  std::vector<std::vector<Stop>> stops;    ///< [path], ascending
  std::vector<std::vector<Visit>> visits;  ///< [vertex]

  explicit Graph(const RoadNetwork& roads, std::vector<Polyline> all) : grid(all, 32.0), lines(std::move(all)) {
    std::map<std::int64_t, int> uses;
    for (const RoadPath& path : roads.paths)
      for (const RoadNode& node : path.nodes)
        if (node.osm_node > 0) ++uses[node.osm_node];
    std::map<std::int64_t, std::size_t> vertex_of;
    stops.resize(roads.paths.size());
    for (std::size_t k = 0; k < roads.paths.size(); ++k)
      for (const RoadNode& node : roads.paths[k].nodes) {
        if (node.osm_node <= 0 || uses[node.osm_node] < 2) continue;
        const auto [at, fresh] = vertex_of.emplace(node.osm_node, vertex_of.size());
        if (fresh) visits.emplace_back();
        visits[at->second].push_back({k, stops[k].size()});
        stops[k].push_back({node.s_m, at->second});
      }
  }

  struct Reached {
    double way_m = std::numeric_limits<double>::infinity();
    std::optional<std::size_t> before;  ///< vertex; none: straight from the start
    Piece piece{};                      ///< that led here
  };
  using Reach = std::map<std::size_t, Reached>;

  /// All vertices within reach when driving on from a place (Dijkstra).
  [[nodiscard]] Reach reach_from(const RoadNetwork& roads, const Candidate& from, double limit_m) const {
    Reach reach;
    using Item = std::pair<double, std::size_t>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    const auto offer = [&](std::size_t vertex, double way_m, std::optional<std::size_t> before, const Piece& piece) {
      if (way_m > limit_m) return;
      Reached& reached = reach[vertex];
      if (way_m >= reached.way_m) return;
      reached = {way_m, before, piece};
      queue.push({way_m, vertex});
    };
    const auto& first = stops[from.path];
    if (from.forward) {
      const auto at =
          std::lower_bound(first.begin(), first.end(), from.s_m, [](const Stop& a, double s) { return a.s_m < s; });
      if (at != first.end()) offer(at->vertex, at->s_m - from.s_m, {}, {from.path, from.s_m, at->s_m});
    } else {
      const auto at =
          std::upper_bound(first.begin(), first.end(), from.s_m, [](double s, const Stop& a) { return s < a.s_m; });
      if (at != first.begin())
        offer((at - 1)->vertex, from.s_m - (at - 1)->s_m, {}, {from.path, from.s_m, (at - 1)->s_m});
    }
    while (!queue.empty()) {
      const auto [way_m, vertex] = queue.top();
      queue.pop();
      const Reached here = reach[vertex];
      if (way_m > here.way_m) continue;
      for (const Visit& visit : visits[vertex]) {
        const auto& along = stops[visit.path];
        const double s = along[visit.stop].s_m;
        // Turning on the spot is no way on.
        const bool came_forward = here.piece.path == visit.path && here.piece.s_to == s && here.piece.s_from < s;
        const bool came_backward = here.piece.path == visit.path && here.piece.s_to == s && here.piece.s_from > s;
        if (visit.stop + 1 < along.size() && !came_backward)
          offer(along[visit.stop + 1].vertex, way_m + along[visit.stop + 1].s_m - s, vertex,
                {visit.path, s, along[visit.stop + 1].s_m});
        if (visit.stop > 0 && !came_forward && roads.paths[visit.path].oneway == Oneway::no)
          offer(along[visit.stop - 1].vertex, way_m + s - along[visit.stop - 1].s_m, vertex,
                {visit.path, s, along[visit.stop - 1].s_m});
      }
    }
    return reach;
  }

  /// The stop before a place in its direction of travel; none before the first.
  [[nodiscard]] const Stop* stop_before(const Candidate& to) const {
    const auto& along = stops[to.path];
    if (to.forward) {
      const auto at =
          std::upper_bound(along.begin(), along.end(), to.s_m, [](double s, const Stop& a) { return s < a.s_m; });
      return at == along.begin() ? nullptr : &*(at - 1);
    }
    const auto at =
        std::lower_bound(along.begin(), along.end(), to.s_m, [](const Stop& a, double s) { return a.s_m < s; });
    return at == along.end() ? nullptr : &*at;
  }

  /// Length of the way from one place to another; infinity when it is out of reach.
  [[nodiscard]] double way_m(const Candidate& from, const Candidate& to, const Reach& reach) const {
    double best = std::numeric_limits<double>::infinity();
    if (from.path == to.path && from.forward == to.forward) {
      const double ahead = from.forward ? to.s_m - from.s_m : from.s_m - to.s_m;
      if (ahead >= -backwards_m) best = std::abs(ahead);
    }
    if (const Stop* stop = stop_before(to))
      if (const auto at = reach.find(stop->vertex); at != reach.end())
        best = std::min(best, at->second.way_m + std::abs(to.s_m - stop->s_m));
    return best;
  }

  [[nodiscard]] std::vector<Piece> pieces(const Candidate& from, const Candidate& to, const Reach& reach) const {
    const double straight = from.path == to.path && from.forward == to.forward
                                ? (from.forward ? to.s_m - from.s_m : from.s_m - to.s_m)
                                : -HUGE_VAL;
    const Stop* stop = stop_before(to);
    const auto at = stop ? reach.find(stop->vertex) : reach.end();
    const double round = at != reach.end() ? at->second.way_m + std::abs(to.s_m - stop->s_m) : HUGE_VAL;
    if (straight >= -backwards_m && std::abs(straight) <= round) return {{from.path, from.s_m, to.s_m}};
    std::vector<Piece> way{{to.path, stop->s_m, to.s_m}};
    for (std::optional<std::size_t> vertex = stop->vertex; vertex; vertex = reach.at(*vertex).before)
      way.push_back(reach.at(*vertex).piece);
    std::reverse(way.begin(), way.end());
    return way;
  }
};

namespace {

std::vector<Polyline> lines_of(const RoadNetwork& roads) {
  std::vector<Polyline> lines;
  for (const RoadPath& path : roads.paths) lines.push_back(centerline(path));
  return lines;
}

/// Direction of travel of every pose: of the attitude, which says it at any speed, or of the positions around.
double travel_heading(const std::vector<DrivePose>& poses, std::size_t i, double slowest_mps) {
  constexpr double chord_m = 5.0;  // long enough for the scatter of positions
  std::size_t a = i, b = i;
  while (a > 0 && distance(poses[a].p, poses[i].p) < chord_m) --a;
  while (b + 1 < poses.size() && distance(poses[b].p, poses[i].p) < chord_m) ++b;
  const double run_m = distance(poses[a].p, poses[b].p), time_s = poses[b].time_s - poses[a].time_s;
  if (run_m >= chord_m && run_m >= slowest_mps * time_s) {
    const Vec2 d = poses[b].p - poses[a].p;
    return std::atan2(d.y, d.x);  // of the movement, not of the car's nose: it may reverse
  }
  return poses[i].heading_rad;
}

std::vector<Keyframe> choose_keyframes(const std::vector<DrivePose>& poses, double spacing_m) {
  std::vector<Keyframe> frames{{0, {}}};
  for (std::size_t i = 1; i < poses.size(); ++i)
    if (distance(poses[i].p, poses[frames.back().pose].p) >= spacing_m) frames.push_back({i, {}});
  if (frames.size() > 1 && frames.back().pose + 1 < poses.size()) frames.back().pose = poses.size() - 1;
  return frames;
}

}  // namespace

LogMatcher::LogMatcher(const RoadNetwork& roads, const MatchLogOptions& options)
    : roads_(roads), options_(options), graph_(std::make_unique<Graph>(roads, lines_of(roads))) {}
LogMatcher::~LogMatcher() = default;

MatchLogResult LogMatcher::match(const DriveRecording& recording, const std::string& name) const {
  const std::vector<DrivePose>& poses = recording.poses;
  MatchLogResult result;
  result.places.resize(poses.size());
  if (poses.empty()) return result;
  std::vector<Keyframe> frames = choose_keyframes(poses, options_.spacing_m);

  // Emissions: eq. 1 of the paper times a normal distribution of the heading.
  const double no_road_log = -0.5 * options_.no_road_sigmas * options_.no_road_sigmas;
  for (Keyframe& frame : frames) {
    const DrivePose& pose = poses[frame.pose];
    const double sigma_m = std::hypot(pose.sigma_p_m, options_.lateral_sigma_m);
    const double reach_m = (options_.no_road_sigmas + 1.0) * sigma_m;
    const double heading = travel_heading(poses, frame.pose, options_.slowest_heading_mps);
    const auto segments = graph_->grid.near(pose.p, reach_m);
    for (std::size_t a = 0; a < segments.size();) {  // the nearest place of every run of segments in a row
      double nearest_m = std::numeric_limits<double>::infinity(), road_heading = 0.0;
      Candidate place;
      std::size_t b = a;
      for (; b < segments.size() && segments[b].line == segments[a].line &&
             segments[b].index - segments[a].index == b - a;
           ++b) {
        const auto& nodes = roads_.paths[segments[b].line].nodes;
        const RoadNode &from = nodes[segments[b].index], &to = nodes[segments[b].index + 1];
        double far_m = 0.0;
        const Vec2 d = to.p - from.p;
        if (!(dot(d, d) > 0.0)) continue;
        const double f = std::clamp(dot(pose.p - from.p, d) / dot(d, d), 0.0, 1.0);
        far_m = distance(pose.p, from.p + d * f);
        if (far_m >= nearest_m) continue;
        nearest_m = far_m, road_heading = std::atan2(d.y, d.x);
        place = {segments[b].line, from.s_m + f * (to.s_m - from.s_m), cross(d, pose.p - from.p) / length(d)};
      }
      a = b;
      if (!(nearest_m < reach_m)) continue;
      for (const bool forward : {true, false}) {
        if (!forward && roads_.paths[place.path].oneway != Oneway::no) continue;
        place.forward = forward;
        const double turn = std::isnan(heading) ? 0.0 : wrapped(heading - road_heading - (forward ? 0.0 : M_PI));
        place.log_emission = -0.5 * (std::pow(nearest_m / sigma_m, 2) + std::pow(turn / options_.heading_sigma_rad, 2));
        if (place.log_emission > 2.0 * no_road_log) frame.candidates.push_back(place);
      }
    }
  }

  // Viterbi. State candidates.size() of a frame is "on no road".
  std::vector<std::vector<double>> score(frames.size());
  std::vector<std::vector<std::size_t>> from(frames.size());
  const auto distance_between = [&](std::size_t k) {
    return distance(poses[frames[k - 1].pose].p, poses[frames[k].pose].p);
  };
  const auto reach_limit = [&](std::size_t k) { return distance_between(k) + longest_detour_m; };
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto& now = frames[k].candidates;
    score[k].assign(now.size() + 1, impossible);
    from[k].assign(now.size() + 1, 0);
    if (k == 0) {
      for (std::size_t c = 0; c < now.size(); ++c) score[k][c] = now[c].log_emission;
      score[k][now.size()] = no_road_log;
      continue;
    }
    const auto& before = frames[k - 1].candidates;
    const double straight_m = distance_between(k);
    const auto offer = [&](std::size_t b, std::size_t c, double log_transition) {
      const double total = score[k - 1][b] + log_transition;
      if (total > score[k][c]) score[k][c] = total, from[k][c] = b;
    };
    for (std::size_t b = 0; b < before.size(); ++b) {
      const Graph::Reach reach = now.empty() ? Graph::Reach{} : graph_->reach_from(roads_, before[b], reach_limit(k));
      for (std::size_t c = 0; c < now.size(); ++c) {
        const double detour_m = std::abs(graph_->way_m(before[b], now[c], reach) - straight_m);  // eq. 2
        if (detour_m <= longest_detour_m) offer(b, c, -detour_m / options_.detour_m);
      }
      offer(b, now.size(), leave_road_log);
    }
    for (std::size_t c = 0; c < now.size(); ++c) offer(before.size(), c, leave_road_log);
    offer(before.size(), now.size(), 0.0);
    for (std::size_t c = 0; c < now.size(); ++c) score[k][c] += now[c].log_emission;
    score[k][now.size()] += no_road_log;
  }
  std::vector<std::size_t> state(frames.size());
  state.back() =
      static_cast<std::size_t>(std::max_element(score.back().begin(), score.back().end()) - score.back().begin());
  for (std::size_t k = frames.size() - 1; k > 0; --k) state[k - 1] = from[k][state[k]];

  // Poses between two matched ones lie on the way between them.
  const auto on_road = [&](std::size_t k) { return state[k] < frames[k].candidates.size(); };
  const auto candidate = [&](std::size_t k) { return frames[k].candidates[state[k]]; };
  const auto take = [&](std::size_t pose, const Candidate& c) {
    result.places[pose] = LogPlace{c.path, c.s_m, c.offset_m, c.forward};
  };
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (on_road(k)) take(frames[k].pose, candidate(k));
    if (k == 0) continue;
    const double run_m = distance_between(k);
    result.length_m += run_m;
    if (!on_road(k - 1) || !on_road(k)) continue;
    result.matched_m += run_m;
    const Candidate a = candidate(k - 1), b = candidate(k);
    const auto way = graph_->pieces(a, b, graph_->reach_from(roads_, a, reach_limit(k)));
    for (std::size_t i = frames[k - 1].pose + 1; i < frames[k].pose; ++i) {
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const Piece& piece : way) {
        double far_m = 0.0;
        LogPlace place = project_between(roads_.paths[piece.path], std::min(piece.s_from, piece.s_to),
                                         std::max(piece.s_from, piece.s_to), poses[i].p, far_m);
        if (far_m >= nearest_m) continue;
        nearest_m = far_m;
        place.path = piece.path;
        place.forward = piece.s_from == piece.s_to ? b.forward : piece.s_to > piece.s_from;
        if (way.size() == 1) place.forward = b.forward;
        result.places[i] = place;
      }
    }
  }

  // What is on no road, stretch by stretch.
  if (std::none_of(result.places.begin(), result.places.end(), [](const auto& place) { return place.has_value(); })) {
    result.findings.push_back(
        {Severity::warning, "drive_log.no_match",
         fmt::format("{}: {:.0f} m from {:.2f} s on match no road", name, result.length_m, poses.front().time_s),
         poses.front().p.x, poses.front().p.y});
    return result;
  }
  for (std::size_t k = 1; k < frames.size();) {
    if (on_road(k) && on_road(k - 1)) {
      ++k;
      continue;
    }
    const std::size_t first = k - 1;
    double run_m = 0.0;
    for (; k < frames.size() && !(on_road(k) && on_road(k - 1)); ++k) run_m += distance_between(k);
    if (run_m < options_.unmatched_finding_m) continue;
    const Vec2 p = poses[frames[first].pose].p;
    result.findings.push_back(
        {Severity::info, "drive_log.unmatched",
         fmt::format("{}: {:.0f} m from {:.2f} s on match no road", name, run_m, poses[frames[first].pose].time_s), p.x,
         p.y});
  }
  return result;
}

}  // namespace orthodrive
