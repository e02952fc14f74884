#include "orthodrive/network/roundabouts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

namespace orthodrive::network {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double max_ring_m = 400.0;   // round the island; the largest roundabouts have 120 m across
constexpr double min_ring_m = 20.0;    // a mini-roundabout of 3 m radius
// Area over that of a circle of the same circumference: 0.785 for a square, 0.95 for an octagon, 0.83 for a regular
// pentagon with rounded corners. A block with one-way streets round it is no roundabout.
constexpr double min_roundness = 0.85, min_tagged_roundness = 0.6;
constexpr double min_assumed_m = 30.0, max_assumed_m = 200.0, min_assumed_roundness = 0.92;
constexpr std::size_t min_assumed_arms = 3;
constexpr double max_gap_share = 1.0 / 3.0;
constexpr double max_circle_error = 0.15;  // of the radius: what is closed along a circle has to look like one
constexpr double node_spacing_m = 2.0;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_tagged_ring(const RoadPath& path) { return path.roundabout && path.oneway == Oneway::forward && path.nodes.size() >= 2; }

struct Circle {
  Vec2 center;
  double radius_m = 0.0, error_m = 0.0;  ///< error: root mean square of the distances from it
};

/// Least squares circle. Based on: I. Kasa, A circle fitting procedure and its error analysis, IEEE Trans. Instrum. Meas.
/// 25 (1976). Linear in the centre and in radius^2 - centre^2.
std::optional<Circle> fit_circle(const std::vector<Vec2>& points) {
  if (points.size() < 3) return std::nullopt;
  Vec2 mean;
  for (const Vec2 p : points) mean = mean + p * (1.0 / static_cast<double>(points.size()));
  double xx = 0.0, xy = 0.0, yy = 0.0, xq = 0.0, yq = 0.0, q_sum = 0.0;
  for (const Vec2 p : points) {
    const Vec2 d = p - mean;
    const double q = dot(d, d);
    xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y, xq += d.x * q, yq += d.y * q, q_sum += q;
  }
  const double det = xx * yy - xy * xy, n = static_cast<double>(points.size());
  if (!(det > 1e-6 * (xx + yy) * (xx + yy))) return std::nullopt;  // on a line
  const Vec2 c{0.5 * (xq * yy - yq * xy) / det, 0.5 * (yq * xx - xq * xy) / det};
  Circle circle{mean + c, std::sqrt(q_sum / n + dot(c, c)), 0.0};
  for (const Vec2 p : points) circle.error_m += std::pow(distance(p, circle.center) - circle.radius_m, 2.0) / n;
  circle.error_m = std::sqrt(circle.error_m);
  return circle;
}

/// Tagged paths in driving order from one that nothing leads into to one that leads into nothing.
struct OpenRing {
  std::vector<std::size_t> paths;
};

std::vector<OpenRing> find_open_rings(const RoadNetwork& roads) {
  std::map<std::int64_t, int> visits;
  std::map<std::int64_t, std::size_t> starts_at;
  for (std::size_t i = 0; i < roads.paths.size(); ++i) {
    const RoadPath& path = roads.paths[i];
    if (!is_tagged_ring(path)) continue;
    for (const RoadNode& node : path.nodes)
      if (node.osm_node > 0) ++visits[node.osm_node];
    starts_at.emplace(path.nodes.front().osm_node, i);
  }
  const auto is_loose = [&](std::int64_t node) { return node > 0 && visits.at(node) == 1; };
  std::vector<OpenRing> found;
  for (std::size_t i = 0; i < roads.paths.size(); ++i) {
    if (!is_tagged_ring(roads.paths[i]) || !is_loose(roads.paths[i].nodes.front().osm_node)) continue;
    OpenRing ring{{i}};
    for (;;) {
      const std::int64_t end = roads.paths[ring.paths.back()].nodes.back().osm_node;
      const auto next = starts_at.find(end);
      if (end <= 0 || next == starts_at.end() || ring.paths.size() > starts_at.size()) break;
      ring.paths.push_back(next->second);
    }
    if (is_loose(roads.paths[ring.paths.back()].nodes.back().osm_node)) found.push_back(std::move(ring));
  }
  return found;
}

/// Nodes on the circle from the end of `last` to the beginning of `first`, in the sense of `turn` (1 = to the left).
void close_along(const Circle& circle, double gap_rad, const RoadNode& first, RoadPath& last) {
  const RoadNode from = last.nodes.back();
  const double r0 = distance(from.p, circle.center), r1 = distance(first.p, circle.center);
  const double a0 = std::atan2(from.p.y - circle.center.y, from.p.x - circle.center.x);
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(gap_rad) * circle.radius_m / node_spacing_m)));
  for (int i = 1; i <= steps; ++i) {
    const double x = static_cast<double>(i) / steps, r = r0 + (r1 - r0) * x, a = a0 + gap_rad * x;
    RoadNode node = first;
    node.p = i == steps ? first.p : circle.center + Vec2{std::cos(a), std::sin(a)} * r;
    node.osm_node = i == steps ? first.osm_node : 0;
    node.s_m = last.nodes.back().s_m + distance(last.nodes.back().p, node.p);
    node.width_m = from.width_m + (first.width_m - from.width_m) * x;
    node.z_m = from.z_m + (first.z_m - from.z_m) * x;
    node.banking = from.banking + (first.banking - from.banking) * x;
    last.nodes.push_back(node);
  }
}

// ---- rings of pieces

double polygon_area(const std::vector<Vec2>& ring) {
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) twice += cross(ring[i] - ring[0], ring[(i + 1) % ring.size()] - ring[0]);
  return 0.5 * twice;
}

class RingFinder {
 public:
  RingFinder(const RoadNetwork& roads, const Topology& topology, bool left_hand_traffic)
      : roads_(roads), topology_(topology), side_(left_hand_traffic ? -1.0 : 1.0), ring_of_(topology.pieces.size(), -1) {}

  std::vector<int> run() {
    int rings = 0;
    for (std::size_t i = 0; i < topology_.pieces.size(); ++i) {
      if (ring_of_[i] >= 0 || !may_ring(static_cast<int>(i))) continue;
      const std::vector<int> round = walk(static_cast<int>(i));
      if (!is_roundabout(round)) continue;
      for (const int piece : round) ring_of_[at(piece)] = rings;
      ++rings;
    }
    return std::move(ring_of_);
  }

 private:
  [[nodiscard]] const RoadPath& path_of(int piece) const { return roads_.paths[at(topology_.pieces[at(piece)].path)]; }
  [[nodiscard]] bool may_ring(int piece) const {
    return path_of(piece).oneway == Oneway::forward && path_of(piece).highway != "raceway";
  }
  [[nodiscard]] double length_m(int piece) const {
    const Piece& p = topology_.pieces[at(piece)];
    const std::vector<RoadNode>& nodes = path_of(piece).nodes;
    double sum = 0.0;
    for (int i = p.first; i < p.last; ++i) sum += distance(nodes[at(i)].p, nodes[at(i) + 1].p);
    return sum;
  }

  /// One-way pieces round the island, always keeping to its side, back to the first; empty when they do not lead back.
  [[nodiscard]] std::vector<int> walk(int first) const {
    std::vector<int> round{first};
    double length = length_m(first);
    for (int piece = first;;) {
      const int vertex = topology_.pieces[at(piece)].last_vertex;
      if (vertex == topology_.pieces[at(first)].first_vertex) return round;
      const Vec2 in = outward(roads_, topology_, {piece, true}) * -1.0;
      int best = -1;
      double best_turn = -INFINITY;
      for (const PieceEnd& end : topology_.vertices[at(vertex)].ends) {
        if (end.at_last || !may_ring(end.piece)) continue;
        if (path_of(first).roundabout && !path_of(end.piece).roundabout) continue;
        const Vec2 out = outward(roads_, topology_, end);
        const double turn = side_ * std::atan2(cross(in, out), dot(in, out));
        if (turn > best_turn) best = end.piece, best_turn = turn;
      }
      if (best < 0 || (length += length_m(best)) > max_ring_m) return {};
      round.push_back(best);
      piece = best;
    }
  }

  [[nodiscard]] bool is_roundabout(const std::vector<int>& round) const {
    std::vector<Vec2> ring;
    double length = 0.0;
    bool tagged = !round.empty();
    for (const int piece : round) {
      const Piece& p = topology_.pieces[at(piece)];
      for (int i = p.first; i < p.last; ++i) ring.push_back(path_of(piece).nodes[at(i)].p);
      length += length_m(piece);
      tagged = tagged && path_of(piece).roundabout;
    }
    if (length < min_ring_m) return false;
    const double roundness = side_ * 4.0 * pi * polygon_area(ring) / (length * length);
    return roundness > (tagged ? min_tagged_roundness : min_roundness);
  }

  const RoadNetwork& roads_;
  const Topology& topology_;
  double side_;
  std::vector<int> ring_of_;
};

// ---- rings that nothing tells but their form

/// Two-way pieces round an island, each with the direction in which it is gone.
class CircleFinder {
 public:
  CircleFinder(const RoadNetwork& roads, const Topology& topology, bool left_hand_traffic)
      : roads_(roads), topology_(topology), side_(left_hand_traffic ? -1.0 : 1.0), used_(topology.pieces.size(), false) {}

  std::vector<std::vector<ChainPiece>> run() {
    std::vector<std::vector<ChainPiece>> found;
    for (std::size_t i = 0; i < topology_.pieces.size(); ++i)
      for (const bool reversed : {false, true}) {
        if (used_[i] || !may_ring(static_cast<int>(i))) continue;
        const std::vector<ChainPiece> round = walk({static_cast<int>(i), reversed});
        if (!is_circle(round)) continue;
        for (const ChainPiece& part : round) used_[at(part.piece)] = true;
        found.push_back(round);
      }
    return found;
  }

 private:
  [[nodiscard]] const Piece& piece_of(const ChainPiece& part) const { return topology_.pieces[at(part.piece)]; }
  [[nodiscard]] const RoadPath& path_of(int piece) const { return roads_.paths[at(topology_.pieces[at(piece)].path)]; }
  [[nodiscard]] bool may_ring(int piece) const {
    const RoadPath& path = path_of(piece);
    return path.oneway == Oneway::no && !path.bridge && !path.tunnel && path.highway != "raceway" &&
           road_rank(path.highway) >= road_rank("living_street");
  }
  [[nodiscard]] std::vector<Vec2> points_of(const ChainPiece& part) const {
    const Piece& piece = piece_of(part);
    std::vector<Vec2> points;
    for (int i = piece.first; i <= piece.last; ++i) points.push_back(path_of(part.piece).nodes[at(i)].p);
    if (part.reversed) std::reverse(points.begin(), points.end());
    return points;
  }

  [[nodiscard]] std::vector<ChainPiece> walk(ChainPiece first) const {
    std::vector<ChainPiece> round{first};
    double length = length_m(points_of(first));
    for (;;) {
      const ChainPiece last = round.back();
      const int vertex = end_vertex(topology_, last);
      if (vertex == start_vertex(topology_, first)) return round;
      const Vec2 in = outward(roads_, topology_, {last.piece, !last.reversed}) * -1.0;
      ChainPiece best{-1, false};
      double best_turn = -INFINITY;
      for (const PieceEnd& end : topology_.vertices[at(vertex)].ends) {
        if (end.piece == last.piece || !may_ring(end.piece)) continue;
        const Vec2 out = outward(roads_, topology_, end);
        const double turn = side_ * std::atan2(cross(in, out), dot(in, out));
        if (turn > best_turn) best = {end.piece, end.at_last}, best_turn = turn;
      }
      if (best.piece < 0 || (length += length_m(points_of(best))) > max_assumed_m) return {};
      round.push_back(best);
    }
  }
  [[nodiscard]] static double length_m(const std::vector<Vec2>& points) {
    double sum = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) sum += distance(points[i - 1], points[i]);
    return sum;
  }

  [[nodiscard]] bool is_circle(const std::vector<ChainPiece>& round) const {
    std::vector<Vec2> ring;
    std::map<int, int> nodes_of_path;  // segments of each path in the ring
    std::size_t arms = 0;
    for (const ChainPiece& part : round) {
      std::vector<Vec2> points = points_of(part);
      ring.insert(ring.end(), points.begin(), points.end() - 1);
      const Piece& piece = piece_of(part);
      nodes_of_path[piece.path] += piece.last - piece.first;
      arms += topology_.vertices[at(end_vertex(topology_, part))].ends.size() - 2;
    }
    if (ring.size() < 8 || arms < min_assumed_arms) return false;
    for (const auto& [path, segments] : nodes_of_path)
      if (segments + 1 != static_cast<int>(roads_.paths[at(path)].nodes.size())) return false;
    ring.push_back(ring.front());
    const double length = length_m(ring);
    ring.pop_back();
    return length >= min_assumed_m && side_ * 4.0 * pi * polygon_area(ring) / (length * length) > min_assumed_roundness;
  }

  const RoadNetwork& roads_;
  const Topology& topology_;
  double side_;
  std::vector<bool> used_;
};

// ---- smooth rings

constexpr std::size_t waves = 5;  // 1, cos a, sin a, cos 2a, sin 2a
constexpr double max_ring_error = 0.1;  // of the radius

std::array<double, waves> wave_values(double angle) {
  return {1.0, std::cos(angle), std::sin(angle), std::cos(2.0 * angle), std::sin(2.0 * angle)};
}

/// The distance from the centre as a sum of waves of the angle, by least squares. nullopt for points of too few angles.
std::optional<std::array<double, waves>> fit_waves(const std::vector<Vec2>& points, Vec2 center) {
  double a[waves][waves + 1] = {};  // normal equations
  for (const Vec2 p : points) {
    const Vec2 d = p - center;
    const auto w = wave_values(std::atan2(d.y, d.x));
    for (std::size_t i = 0; i < waves; ++i) {
      for (std::size_t k = 0; k < waves; ++k) a[i][k] += w[i] * w[k];
      a[i][waves] += w[i] * length(d);
    }
  }
  for (std::size_t i = 0; i < waves; ++i) {  // symmetric and positive: no pivoting needed
    if (!(a[i][i] > 1e-6)) return std::nullopt;
    for (std::size_t r = 0; r < waves; ++r) {
      if (r == i) continue;
      const double factor = a[r][i] / a[i][i];
      for (std::size_t k = i; k <= waves; ++k) a[r][k] -= factor * a[i][k];
    }
  }
  std::array<double, waves> result;
  for (std::size_t i = 0; i < waves; ++i) result[i] = a[i][waves] / a[i][i];
  return result;
}

/// A ring's nodes as indices of paths and nodes; each once.
std::vector<std::pair<int, int>> ring_nodes(const Topology& topology, int ring) {
  std::vector<std::pair<int, int>> nodes;
  for (std::size_t i = 0; i < topology.pieces.size(); ++i) {
    const Piece& piece = topology.pieces[i];
    if (topology.ring_of_piece[i] != ring) continue;
    for (int k = piece.first; k <= piece.last; ++k) nodes.emplace_back(piece.path, k);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

void turn_round(RoadPath& path) {
  const double length = path.nodes.back().s_m;
  std::reverse(path.nodes.begin(), path.nodes.end());
  for (RoadNode& node : path.nodes) {
    node.s_m = length - node.s_m;
    node.offset_m = -node.offset_m, node.gradient = -node.gradient, node.banking = -node.banking;
  }
  const auto mirrored = [](Sides s) { return s == Sides::left ? Sides::right : s == Sides::right ? Sides::left : s; };
  path.sidewalk = mirrored(path.sidewalk), path.shoulder = mirrored(path.shoulder);
  std::swap(path.turn_forward, path.turn_backward);
}

}  // namespace

RoadNetwork assume_roundabouts(RoadNetwork roads, bool left_hand_traffic, Findings& findings) {
  Findings unused;  // told when the topology is built for good
  const Topology topology = build_topology(roads, left_hand_traffic, unused);
  for (const std::vector<ChainPiece>& round : CircleFinder(roads, topology, left_hand_traffic).run()) {
    std::map<int, bool> paths;  // whether they are turned
    for (const ChainPiece& part : round) paths[topology.pieces[at(part.piece)].path] = part.reversed;
    for (const auto& [index, reversed] : paths) {
      RoadPath& path = roads.paths[at(index)];
      if (reversed) turn_round(path);
      path.oneway = Oneway::forward;
      path.lanes = path.lanes > 1 ? path.lanes / 2 : path.lanes;
      path.lanes_forward = path.lanes, path.lanes_backward = 0;
      path.turn_backward.clear();
    }
    const RoadPath& path = roads.paths[at(paths.begin()->first)];
    findings.push_back({Severity::warning, "network.roundabout_assumed",
                        fmt::format("way {}: a circle of two-way road with arms; took it as a roundabout", path.osm_id),
                        path.nodes.front().p.x, path.nodes.front().p.y});
  }
  return roads;
}

RoadNetwork close_roundabouts(RoadNetwork roads, Findings& findings) {
  for (const OpenRing& open : find_open_rings(roads)) {
    std::vector<Vec2> points;
    for (const std::size_t i : open.paths)
      for (const RoadNode& node : roads.paths[i].nodes) points.push_back(node.p);
    const RoadNode first = roads.paths[open.paths.front()].nodes.front();
    RoadPath& last = roads.paths[open.paths.back()];
    const auto tell = [&](const char* code, const std::string& what) {
      findings.push_back({Severity::warning, code, fmt::format("way {}: {}", last.osm_id, what), first.p.x, first.p.y});
    };
    const std::optional<Circle> circle = fit_circle(points);
    const double turn = polygon_area(points) > 0.0 ? 1.0 : -1.0;
    double gap_rad = 0.0;
    if (circle) {
      const Vec2 a = last.nodes.back().p - circle->center, b = first.p - circle->center;
      gap_rad = turn * std::atan2(cross(a, b), dot(a, b));
      if (gap_rad < 0.0) gap_rad += 2.0 * pi;
    }
    if (!circle || circle->error_m > max_circle_error * circle->radius_m || gap_rad > max_gap_share * 2.0 * pi) {
      tell("network.roundabout_open", "a roundabout that is not closed and does not look like a circle; took it as a one-way road");
      continue;
    }
    tell("network.roundabout_closed", fmt::format("a roundabout that is not closed; closed the gap of {:.1f} m along its circle",
                                                  gap_rad * circle->radius_m));
    close_along(*circle, turn * gap_rad, first, last);
  }
  return roads;
}

std::vector<int> find_rings(const RoadNetwork& roads, const Topology& topology, bool left_hand_traffic) {
  return RingFinder(roads, topology, left_hand_traffic).run();
}

void smooth_rings(RoadNetwork& roads, Topology& topology) {
  int rings = 0;
  for (const int ring : topology.ring_of_piece) rings = std::max(rings, ring + 1);
  for (int ring = 0; ring < rings; ++ring) {
    const std::vector<std::pair<int, int>> nodes = ring_nodes(topology, ring);
    const auto place = [&](const std::pair<int, int>& node) -> Vec2& { return roads.paths[at(node.first)].nodes[at(node.second)].p; };
    std::vector<Vec2> points;
    for (const auto& node : nodes) points.push_back(place(node));
    const std::optional<Circle> circle = fit_circle(points);
    const auto radius = circle ? fit_waves(points, circle->center) : std::nullopt;
    if (!radius) continue;
    const auto moved = [&](Vec2 p) {
      const Vec2 d = p - circle->center;
      const auto w = wave_values(std::atan2(d.y, d.x));
      double r = 0.0;
      for (std::size_t i = 0; i < waves; ++i) r += (*radius)[i] * w[i];
      return circle->center + normalized(d) * r;
    };
    const bool fits = std::all_of(points.begin(), points.end(), [&](Vec2 p) {
      return distance(p, moved(p)) <= max_ring_error * circle->radius_m;
    });
    if (!fits) continue;
    for (const auto& node : nodes) place(node) = moved(place(node));
    for (std::size_t i = 0; i < topology.pieces.size(); ++i) {
      if (topology.ring_of_piece[i] != ring) continue;
      const Piece& piece = topology.pieces[i];
      topology.vertices[at(piece.first_vertex)].p = place({piece.path, piece.first});
      topology.vertices[at(piece.last_vertex)].p = place({piece.path, piece.last});
    }
  }
}

}  // namespace orthodrive::network
