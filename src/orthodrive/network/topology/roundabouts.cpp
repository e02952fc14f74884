// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/roundabouts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "orthodrive/geo/roundness.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/network/curves/fit_circle.hpp"
#include "orthodrive/network/topology/rings.hpp"
#include "orthodrive/roads/ring_paths.hpp"

namespace orthodrive::network {
namespace {

constexpr double min_assumed_m = 30.0, max_assumed_m = 200.0, min_assumed_roundness = 0.92;
constexpr std::size_t min_assumed_arms = 3;
constexpr double max_gap_share = 1.0 / 3.0;
constexpr double max_circle_error = 0.15;  // of the radius: what is closed along a circle has to look like one
constexpr double node_spacing_m = 2.0;
constexpr double min_turned_roundness = 0.3;  // lenses and squares turn, too

bool is_tagged_ring(const RoadPath& path) {
  return path.roundabout && path.oneway == Oneway::forward && path.nodes.size() >= 2;
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
      if (is_osm_node(node.osm_node)) ++visits[node.osm_node];
    starts_at.emplace(path.nodes.front().osm_node, i);
  }
  const auto is_loose = [&](std::int64_t node) { return is_osm_node(node) && visits.at(node) == 1; };
  std::vector<OpenRing> found;
  for (std::size_t i = 0; i < roads.paths.size(); ++i) {
    if (!is_tagged_ring(roads.paths[i]) || !is_loose(roads.paths[i].nodes.front().osm_node)) continue;
    OpenRing ring{{i}};
    for (;;) {
      const std::int64_t end = roads.paths[ring.paths.back()].nodes.back().osm_node;
      const auto next = starts_at.find(end);
      if (!is_osm_node(end) || next == starts_at.end() || ring.paths.size() > starts_at.size()) break;
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
    node.osm_node = i == steps ? first.osm_node : no_osm_node;
    node.s_m = last.nodes.back().s_m + distance(last.nodes.back().p, node.p);
    node.width_m = from.width_m + (first.width_m - from.width_m) * x;
    node.z_m = from.z_m + (first.z_m - from.z_m) * x;
    node.banking = from.banking + (first.banking - from.banking) * x;
    last.nodes.push_back(node);
  }
}

// ---- rings that nothing tells but their form

/// Two-way pieces round an island, each with the direction in which it is gone.
class CircleFinder {
 public:
  CircleFinder(const RoadNetwork& roads, const RoadPieces& pieces, DrivingSide driving_side)
      : roads_(roads),
        pieces_(pieces),
        side_(driving_side == DrivingSide::left ? -1.0 : 1.0),
        used_(pieces.pieces.size(), false) {}

  std::vector<std::vector<DirectedPiece>> run() {
    const auto goes_on = [&](DirectedPiece from, PieceEnd next) {
      return next.piece != from.piece && may_ring(next.piece);
    };
    std::vector<std::vector<DirectedPiece>> found;
    for (const PieceIndex first : pieces_.pieces.indices())
      for (const bool reversed : {false, true}) {
        if (used_[first] || !may_ring(first)) continue;
        const std::vector<DirectedPiece> round =
            walk_round(roads_, pieces_, {first, reversed}, {.side = side_, .max_length_m = max_assumed_m}, goes_on);
        if (!is_circle(round)) continue;
        for (const DirectedPiece part : round) used_[part.piece] = true;
        found.push_back(round);
      }
    return found;
  }

 private:
  [[nodiscard]] bool may_ring(PieceIndex piece) const {
    const RoadPath& path = roads_.paths[pieces_.pieces[piece].path];
    return path.oneway == Oneway::no && !path.bridge && !path.tunnel && !is_raceway(path.highway) &&
           road_rank(path.highway) >= road_rank("living_street");
  }

  [[nodiscard]] bool is_circle(const std::vector<DirectedPiece>& round) const {
    Ring ring;
    std::map<std::size_t, std::size_t> segments_of_path;  // in the ring
    std::size_t arms = 0;
    for (const DirectedPiece part : round) {
      const PathPiece& piece = pieces_.pieces[part.piece];
      Polyline points = points_of(roads_, piece);
      if (part.reversed) std::reverse(points.begin(), points.end());
      ring.insert(ring.end(), points.begin(), points.end() - 1);
      segments_of_path[piece.path] += piece.last - piece.first;
      arms += pieces_.vertices[end_vertex(pieces_, part)].ends.size() - 2;
    }
    if (ring.size() < 8 || arms < min_assumed_arms) return false;
    for (const auto& [path, segments] : segments_of_path)
      if (segments + 1 != roads_.paths[path].nodes.size()) return false;
    const double around_m = length_m(ring) + distance(ring.back(), ring.front());
    return around_m >= min_assumed_m && side_ * roundness(ring) > min_assumed_roundness;
  }

  const RoadNetwork& roads_;
  const RoadPieces& pieces_;
  double side_;
  Table<PieceIndex, bool> used_;
};

}  // namespace

RoadNetwork assume_roundabouts(RoadNetwork roads, DrivingSide driving_side, Findings& findings) {
  Findings unused;  // told when the pieces are cut for good
  const RoadPieces pieces = cut_into_pieces(roads, driving_side, unused);
  for (const std::vector<DirectedPiece>& round : CircleFinder(roads, pieces, driving_side).run()) {
    std::map<std::size_t, bool> paths;  // whether they are turned
    for (const DirectedPiece part : round) paths[pieces.pieces[part.piece].path] = part.reversed;
    for (const auto& [index, reversed] : paths) {
      RoadPath& path = roads.paths[index];
      if (reversed) turn_round(path);
      path.oneway = Oneway::forward;
      path.lanes = path.lanes > 1 ? path.lanes / 2 : path.lanes;
      path.lanes_forward = path.lanes, path.lanes_backward = path.lanes_both_ways = 0;
      path.turn_backward.clear(), path.use_backward.clear(), path.widths_backward.clear();
    }
    const RoadPath& path = roads.paths[paths.begin()->first];
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
    const double turn = signed_area_m2(points) > 0.0 ? 1.0 : -1.0;
    double gap_rad = 0.0;
    if (circle) {
      const Vec2 a = last.nodes.back().p - circle->center, b = first.p - circle->center;
      gap_rad = turn * std::atan2(cross(a, b), dot(a, b));
      if (gap_rad < 0.0) gap_rad += 2.0 * std::numbers::pi;
    }
    if (!circle || circle->error_m > max_circle_error * circle->radius_m ||
        gap_rad > max_gap_share * 2.0 * std::numbers::pi) {
      tell("network.roundabout_open",
           "a roundabout that is not closed and does not look like a circle; took it as a one-way road");
      continue;
    }
    tell("network.roundabout_closed",
         fmt::format("a roundabout that is not closed; closed the gap of {:.1f} m along its circle",
                     gap_rad * circle->radius_m));
    close_along(*circle, turn * gap_rad, first, last);
  }
  return roads;
}

void report_turned_roundabouts(const RoadNetwork& roads, DrivingSide driving_side, Findings& findings) {
  struct TaggedRing {
    std::size_t first = 0;  // path
    double length_m = 0.0;
    Vec2 gap;  // from where its paths end to where they begin: none of a closed one
    std::vector<std::size_t> paths;
  };
  const std::vector<int> ring_of = rings_of_paths(roads);
  std::map<int, TaggedRing> rings;
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    const RoadPath& path = roads.paths[p];
    if (!is_tagged_ring(path) || ring_of[p] < 0) continue;
    TaggedRing& ring = rings.try_emplace(ring_of[p], TaggedRing{.first = p}).first->second;
    ring.paths.push_back(p);
    ring.length_m += length_m(centerline(path));
    ring.gap = ring.gap + (path.nodes.front().p - path.nodes.back().p);
  }
  for (const auto& [number, ring] : rings) {
    if (length(ring.gap) > max_gap_share * ring.length_m) continue;
    const Vec2 origin = roads.paths[ring.first].nodes.front().p;
    double twice_area_m2 = 0.0;  // of a closed line the order of its pieces does not matter
    for (const std::size_t p : ring.paths)
      for (std::size_t i = 0; i + 1 < roads.paths[p].nodes.size(); ++i)
        twice_area_m2 += cross(roads.paths[p].nodes[i].p - origin, roads.paths[p].nodes[i + 1].p - origin);
    const double round = 2.0 * std::numbers::pi * twice_area_m2 / (ring.length_m * ring.length_m);
    const bool is_left = driving_side == DrivingSide::left;
    if ((is_left ? -round : round) > -min_turned_roundness) continue;
    findings.push_back(
        {Severity::warning, "network.roundabout_against_traffic",
         fmt::format(
             "way {}: a roundabout that is drawn {}, where one drives on the {}; turn its way round in the map, "
             "or check the driving side",
             roads.paths[ring.first].osm_id, is_left ? "anticlockwise" : "clockwise", is_left ? "left" : "right"),
         origin.x, origin.y});
  }
}

}  // namespace orthodrive::network
