// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/trace_paths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "orthodrive/geo/segment.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::refine {
namespace {

constexpr double apart_m = 20.0;                              // further from every road: no road of the map
constexpr double shortest_m = 50.0;                           // less is a yard or an error
constexpr double same_path_m = 15.0, least_path_cos = 0.866;  // two traces of one path: 15 m and 30 degrees
constexpr double step_m = 2.0;                                // between the points of a trace that are looked at
constexpr double onwards_m = 60.0;    // so far a trace is followed to the road where it leaves it
constexpr double along_m = 8.0;       // that near and parallel it is on the road already
constexpr double at_node_m = 5.0;     // nearer to a node of the road: that one
constexpr double lap_m = 45.0;        // nearer along the trace it is the same place, not another lap
constexpr double run_up_m = 12.0;     // before it meets the road it is straight
constexpr double smoothing_m = 10.0;  // receivers jitter
constexpr std::int64_t first_new_node = 9'000'000'000'000'000;  // OSM's ids are below for long
constexpr double new_width_m = 4.5;  // between a track's 3.5 m and the 5.5 m of a road: half to 1.8 times is looked for
const char* const new_highway = "track";  // what maps lack is small; it gives way where it meets a road

/// A trace at even steps. A point is open while no road is known there.
struct TraceWalk {
  Polyline line;
  std::vector<Vec2> direction;
  std::vector<bool> seen, open;  // inside the evidence
  std::size_t recording = 0;
};

/// From point `first` to point `last` of a walk.
struct Stretch {
  std::size_t walk = 0, first = 0, last = 0;
  std::optional<std::size_t> onto = {};  ///< it goes on along itself from this point: a circuit, or a loop at its end
  [[nodiscard]] double length_m() const { return step_m * static_cast<double>(last - first); }
};

TraceWalk walk_of(const MovingTrace& trace, const RoadEvidence& evidence) {
  TraceWalk walk{.recording = trace.recording};
  const std::vector<double> s = arc_lengths_m(trace.line);
  std::size_t k = 0;
  for (double at = 0.0; at <= s.back(); at += step_m) {
    while (k + 2 < s.size() && s[k + 1] < at) ++k;
    const double f = (at - s[k]) / (s[k + 1] - s[k]);
    walk.line.push_back(trace.line[k] + (trace.line[k + 1] - trace.line[k]) * f);
    walk.direction.push_back(trace.direction[k]);
    const Vec2 pixel = evidence.frame.pixel_from_world(walk.line.back());
    const int col = static_cast<int>(std::floor(pixel.x)), row = static_cast<int>(std::floor(pixel.y));
    walk.seen.push_back(evidence.outside.inside(col, row) &&
                        (evidence.outside.at(col, row) > 0 || evidence.inside.at(col, row) > 0));
  }
  return walk;
}

/// The roads known so far: those of the map and, one by one, the new ones.
class KnownRoads {
 public:
  explicit KnownRoads(const RoadNetwork& osm) : first_new_(osm.paths.size()), lines_(lines_of(osm)), index_(lines_) {
    for (const RoadPath& path : osm.paths) joinable_.push_back(!path.bridge && !path.tunnel);
  }
  void add(Polyline line) {
    lines_.push_back(std::move(line));
    joinable_.push_back(true);
  }
  [[nodiscard]] bool road_within(Vec2 p, double reach_m) const { return nearest(p, reach_m, false).has_value(); }

  struct RoadBeside {
    std::size_t path = 0;
    double distance_m = 0.0;
    Vec2 direction;  ///< of the road
  };
  /// Bridges and tunnels have no exits: not among them.
  [[nodiscard]] std::optional<RoadBeside> joinable_within(Vec2 p, double reach_m) const {
    return nearest(p, reach_m, true);
  }

 private:
  static std::vector<Polyline> lines_of(const RoadNetwork& osm) {
    std::vector<Polyline> lines;
    lines.reserve(osm.paths.size());
    for (const RoadPath& path : osm.paths) lines.push_back(centerline(path));
    return lines;
  }
  [[nodiscard]] std::optional<RoadBeside> nearest(Vec2 p, double reach_m, bool joinable) const {
    std::optional<RoadBeside> best;
    const auto look = [&](std::size_t line, std::size_t i) {
      const Vec2 a = lines_[line][i], b = lines_[line][i + 1];
      const double d = distance_to_segment(a, b, p);
      if (d <= reach_m && (!best || d < best->distance_m)) best = RoadBeside{line, d, normalized(b - a)};
    };
    for (const auto [line, i] : index_.near(p, reach_m))
      if (!joinable || joinable_[line]) look(line, i);
    for (std::size_t line = first_new_; line < lines_.size(); ++line)
      for (std::size_t i = 0; i + 1 < lines_[line].size(); ++i) look(line, i);
    return best;
  }

  std::size_t first_new_;
  std::vector<Polyline> lines_;
  std::vector<bool> joinable_;
  SegmentIndex index_;
};

/// Ends a stretch where it comes back to itself: the driver turned round, or drove another lap.
void cut_at_return(const TraceWalk& walk, Stretch& stretch) {
  const auto lap = static_cast<std::size_t>(lap_m / step_m);
  for (std::size_t i = stretch.first; i <= stretch.last; ++i)
    for (std::size_t k = stretch.first; k < i; ++k) {
      const double alignment = dot(walk.direction[i], walk.direction[k]);
      const bool back = alignment<-least_path_cos, again = alignment> least_path_cos && i - k > lap;
      if (!(back || again) || distance(walk.line[i], walk.line[k]) >= same_path_m) continue;
      stretch.last = i;
      if (again)
        stretch.onto = k == stretch.first ? k : std::min(k + static_cast<std::size_t>(same_path_m / step_m), i);
      return;
    }
}

/// The longest open stretch of a walk, none when that is too short.
std::optional<Stretch> longest_stretch(const std::vector<TraceWalk>& walks, std::size_t w) {
  const TraceWalk& walk = walks[w];
  std::optional<Stretch> longest;
  for (std::size_t first = 0; first < walk.open.size(); ++first) {
    if (!walk.open[first]) continue;
    Stretch run{w, first, first};
    while (run.last + 1 < walk.open.size() && walk.open[run.last + 1]) ++run.last;
    if (run.length_m() >= shortest_m) cut_at_return(walk, run);
    first = run.last;  // what comes after a return is another stretch
    if (run.length_m() >= shortest_m && (!longest || run.length_m() > longest->length_m())) longest = run;
  }
  return longest;
}

/// Closes what runs within 15 m and 30 degrees of a stretch, and the stretch itself. Returns the walks that changed.
std::set<std::size_t> close_along(std::vector<TraceWalk>& walks, const Stretch& stretch) {
  const TraceWalk taken = walks[stretch.walk];
  const Polyline line(taken.line.begin() + static_cast<std::ptrdiff_t>(stretch.first),
                      taken.line.begin() + static_cast<std::ptrdiff_t>(stretch.last) + 1);
  const Box2 box = bounds_of(line).grown(same_path_m);
  const SegmentIndex index(std::span(&line, 1));
  std::set<std::size_t> changed{stretch.walk};
  for (std::size_t w = 0; w < walks.size(); ++w)
    for (std::size_t i = 0; i < walks[w].line.size(); ++i) {
      TraceWalk& walk = walks[w];
      if (!walk.open[i] || !box.contains(walk.line[i])) continue;
      const auto near = index.near(walk.line[i], same_path_m);
      const bool along = std::ranges::any_of(near, [&](const SegmentIndex::Segment& at) {
        return distance_to_segment(line[at.index], line[at.index + 1], walk.line[i]) <= same_path_m &&
               std::abs(dot(taken.direction[stretch.first + at.index], walk.direction[i])) >= least_path_cos;
      });
      if (along) walk.open[i] = false, changed.insert(w);
    }
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) walks[stretch.walk].open[i] = false;
  return changed;
}

/// Where the walk meets a road when it goes on from point `from`, forwards or backwards.
struct Arrival {
  std::size_t point = 0;  ///< of the walk
  std::size_t path = 0;
};
std::optional<Arrival> follow_to_road(const TraceWalk& walk, std::size_t from, bool forwards, const KnownRoads& known) {
  constexpr double near_enough_m = 1.0;
  struct Step {
    std::size_t point, path;
    double distance_m;
  };
  std::vector<Step> steps;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k <= static_cast<std::size_t>(onwards_m / step_m); ++k) {
    if (forwards ? from + k >= walk.line.size() : k > from) break;
    const std::size_t i = forwards ? from + k : from - k;
    if (!walk.seen[i]) break;
    const auto place = known.joinable_within(walk.line[i], apart_m + step_m);
    if (!place) {
      if (k * step_m > apart_m) break;  // away again
      continue;
    }
    steps.push_back({i, place->path, place->distance_m});
    nearest_m = std::min(nearest_m, place->distance_m);
    if (place->distance_m < along_m && std::abs(dot(place->direction, walk.direction[i])) > least_path_cos) break;
  }
  for (const Step& step : steps)
    if (step.distance_m <= nearest_m + near_enough_m) return Arrival{step.point, step.path};
  return std::nullopt;
}

std::int64_t next_node_id(const RoadNetwork& roads) {
  std::int64_t next = first_new_node;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes) next = std::max(next, node.osm_node + 1);
  return next;
}

/// A node of the path with an id, at its place nearest to p: one that is there, or a new one.
RoadNode node_at(RoadPath& path, Vec2 p, std::int64_t& next_node) {
  const LineProjection place = project_onto(centerline(path), p);
  RoadNode& before = path.nodes[place.segment];
  RoadNode& after = path.nodes[place.segment + 1];
  RoadNode& nearer = distance(before.p, place.point) <= distance(after.p, place.point) ? before : after;
  const double to_nearer_m = distance(nearer.p, place.point);
  if (to_nearer_m < 0.01 || (to_nearer_m < at_node_m && is_osm_node(nearer.osm_node))) {
    if (!is_osm_node(nearer.osm_node)) nearer.osm_node = next_node++;
    return nearer;
  }
  RoadNode node = before;
  node.p = place.point;
  node.s_m = before.s_m + distance(before.p, node.p);
  node.osm_node = next_node++;
  path.nodes.insert(path.nodes.begin() + static_cast<std::ptrdiff_t>(place.segment) + 1, node);
  return node;
}

/// At even steps of about step_m.
Polyline resampled(const Polyline& line) {
  const double length = length_m(line);
  const int steps = std::max(1, static_cast<int>(std::lround(length / step_m)));
  Polyline result;
  for (int i = 0; i <= steps; ++i) result.push_back(point_at(line, length * i / steps));
  return result;
}

/// Moving means; the ends stay, and the window is even around every point, so that straight lines stay straight.
Polyline smoothed(const Polyline& line) {
  const auto reach = static_cast<std::ptrdiff_t>(smoothing_m / step_m);
  const std::ptrdiff_t count = std::ssize(line);
  Polyline result;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t half = std::min({reach, i, count - 1 - i});
    Vec2 sum;
    for (std::ptrdiff_t k = i - half; k <= i + half; ++k) sum = sum + line[static_cast<std::size_t>(k)];
    result.push_back(sum * (1.0 / static_cast<double>(2 * half + 1)));
  }
  return result;
}

/// Ends the path in its own node nearest to p; its first node makes it a closed path.
void join_itself(RoadPath& path, Vec2 p, std::int64_t& next_node) {
  const double away_m = length_m(centerline(path)) - lap_m / 2.0;
  const std::vector<double> s = arc_lengths_m(centerline(path));
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < s.size() && s[i] < away_m; ++i)
    if (distance(path.nodes[i].p, p) < distance(path.nodes[nearest].p, p)) nearest = i;
  RoadNode& node = path.nodes[nearest];
  if (!is_osm_node(node.osm_node)) node.osm_node = next_node++;
  path.nodes.push_back(node);
}

struct NewPath {
  RoadPath path;
  int joined = 0;  ///< ends that meet a road, or the path itself
};

NewPath make_path(const TraceWalk& walk, const Stretch& stretch, const KnownRoads& known, RoadNetwork& roads,
                  std::int64_t& next_node) {
  std::optional<Arrival> start, end;
  if (stretch.onto != stretch.first) start = follow_to_road(walk, stretch.first, false, known);
  if (!stretch.onto) end = follow_to_road(walk, stretch.last, true, known);
  Polyline line(walk.line.begin() + static_cast<std::ptrdiff_t>(start ? start->point : stretch.first),
                walk.line.begin() + static_cast<std::ptrdiff_t>(end ? end->point : stretch.last) + 1);
  NewPath made;
  const auto join = [&](const Arrival& at, bool back) {
    const RoadNode node = node_at(roads.paths[at.path], walk.line[at.point], next_node);
    // The map and the receiver are shifted against each other: without a run-up the path would turn about at its end.
    while (line.size() > 1 && distance(back ? line.back() : line.front(), node.p) < run_up_m)
      line.erase(back ? line.end() - 1 : line.begin());
    line.insert(back ? line.end() : line.begin(), node.p);
    ++made.joined;
    return node.osm_node;
  };
  const std::int64_t first_node = start ? join(*start, false) : 0, last_node = end ? join(*end, true) : 0;
  RoadPath& path = made.path;
  path.highway = new_highway;
  for (const Vec2 p : smoothed(resampled(line))) path.nodes.push_back({.p = p});
  path.nodes.front().osm_node = first_node;
  path.nodes.back().osm_node = last_node;
  if (stretch.onto) join_itself(path, walk.line[*stretch.onto], next_node), ++made.joined;
  const std::vector<double> s = arc_lengths_m(centerline(path));
  for (std::size_t i = 0; i < s.size(); ++i) {
    path.nodes[i].s_m = s[i];
    path.nodes[i].width_m = new_width_m;
  }
  return made;
}

/// Recordings that run along at least half of a stretch.
std::size_t recordings_along(const std::vector<TraceWalk>& walks, const SegmentIndex& index, const Stretch& stretch) {
  const TraceWalk& taken = walks[stretch.walk];
  std::map<std::size_t, std::size_t> points;
  for (std::size_t i = stretch.first; i <= stretch.last; ++i) {
    std::set<std::size_t> here;
    for (const auto [w, k] : index.near(taken.line[i], same_path_m + step_m))
      if (distance(walks[w].line[k], taken.line[i]) <= same_path_m + step_m &&
          std::abs(dot(walks[w].direction[k], taken.direction[i])) >= least_path_cos)
        here.insert(walks[w].recording);
    for (const std::size_t recording : here) ++points[recording];
  }
  return static_cast<std::size_t>(std::ranges::count_if(
      points, [&](const auto& point) { return 2 * point.second >= stretch.last - stretch.first; }));
}

}  // namespace

RoadNetwork with_paths_of_traces(const RoadNetwork& osm, const RoadEvidence& evidence,
                                 const std::vector<MovingTrace>& traces, Findings& findings) {
  RoadNetwork roads = osm;
  KnownRoads known(osm);
  std::vector<TraceWalk> walks;
  for (const MovingTrace& trace : traces) {
    TraceWalk walk = walk_of(trace, evidence);
    for (std::size_t i = 0; i < walk.line.size(); ++i)
      walk.open.push_back(walk.seen[i] && length(walk.direction[i]) > 0.0 && !known.road_within(walk.line[i], apart_m));
    walks.push_back(std::move(walk));
  }
  std::vector<Polyline> lines;
  lines.reserve(walks.size());
  for (const TraceWalk& walk : walks) lines.push_back(walk.line);
  const SegmentIndex index(lines);
  std::vector<std::optional<Stretch>> candidates;
  candidates.reserve(walks.size());
  for (std::size_t w = 0; w < walks.size(); ++w) candidates.push_back(longest_stretch(walks, w));
  std::int64_t next_node = next_node_id(osm), next_way = -1;
  for (const RoadPath& path : osm.paths) next_way = std::min(next_way, path.osm_id - 1);
  for (;;) {
    std::optional<Stretch> longest;
    for (const auto& candidate : candidates)
      if (candidate && (!longest || candidate->length_m() > longest->length_m())) longest = candidate;
    if (!longest) return roads;
    NewPath made = make_path(walks[longest->walk], *longest, known, roads, next_node);
    made.path.osm_id = next_way--;
    const Polyline line = centerline(made.path);
    const Vec2 middle = point_at(line, 0.5 * made.path.nodes.back().s_m);
    findings.push_back(
        {Severity::info, "refine.path_from_gpx",
         fmt::format("way {}: {:.0f} m of {} that OSM lacks, from GPX traces of {} recording(s); {} of its "
                     "ends meet a road",
                     made.path.osm_id, made.path.nodes.back().s_m, new_highway,
                     recordings_along(walks, index, *longest), made.joined),
         middle.x, middle.y});
    known.add(line);
    roads.paths.push_back(std::move(made.path));
    for (const std::size_t w : close_along(walks, *longest)) candidates[w] = longest_stretch(walks, w);
  }
}

}  // namespace orthodrive::refine
