// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/topology/carriageways.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/network/topology/topology.hpp"

namespace orthodrive::network {
namespace {

constexpr double sample_apart_m = 5.0;
constexpr double least_apart_m = 3.0, most_apart_m = 30.0;  // between centre lines
constexpr double most_turned_rad = 20.0 * std::numbers::pi / 180.0;
constexpr double least_share = 0.6, most_share_on_other_side = 0.2;

/// The way that a path may be driven: 0 = both, 1 = along it, -1 = against it.
using Ways = std::vector<int>;

bool may_be_carriageway(const RoadPath& path) {
  return path.oneway == Oneway::no && !path.roundabout && !is_raceway(path.highway) &&
         road_rank(path.highway) >= road_rank("tertiary");
}

class CarriagewayFinder {
 public:
  CarriagewayFinder(const RoadNetwork& roads, const Topology& topology, DrivingSide driving_side)
      : roads_(roads),
        topology_(topology),
        oncoming_side_(driving_side == DrivingSide::right ? 1 : -1),
        chain_of_piece_(topology.pieces.size()) {
    for (const ChainIndex c : topology.chains.indices())
      for (const DirectedPiece part : topology.chains[c].pieces) chain_of_piece_[part.piece] = c;
    for (const PathPiece& piece : topology.pieces) lines_.push_back(points_of(roads, piece));
    index_ = SegmentIndex(lines_);
  }

  Ways run() {
    Ways ways = seen_ways();
    follow(ways);
    while (drop_closed(ways)) {
    }
    return ways;
  }

 private:
  struct Neighbours {
    int samples = 0, left = 0, right = 0;
  };

  /// 1: a neighbour to the left is the nearest one, -1: one to the right, 0: none.
  [[nodiscard]] int nearest_side(PieceIndex own, Vec2 p, Vec2 direction) const {
    const RoadPath& path = roads_.paths[topology_.pieces[own].path];
    const Vec2 across = left_normal(direction);
    double nearest_m = INFINITY;
    for (const auto& [line, i] : index_.near(p, most_apart_m)) {
      const PieceIndex other(line);
      const RoadPath& beside = roads_.paths[topology_.pieces[other].path];
      if (chain_of_piece_[other] == chain_of_piece_[own] || !may_be_carriageway(beside) ||
          beside.highway != path.highway || beside.name != path.name)
        continue;
      const Vec2 a = lines_[line][i] - p, d = lines_[line][i + 1] - lines_[line][i];
      const double along = dot(d, direction), turned_rad = std::atan2(std::abs(cross(d, direction)), std::abs(along));
      if (turned_rad > most_turned_rad) continue;
      const double share = -dot(a, direction) / along;  // where the segment lies straight beside p
      if (share < 0.0 || share > 1.0) continue;
      const double offset_m = dot(a + d * share, across);
      if (std::abs(offset_m) >= least_apart_m && std::abs(offset_m) < std::min(std::abs(nearest_m), most_apart_m))
        nearest_m = offset_m;
    }
    return std::isinf(nearest_m) ? 0 : nearest_m > 0.0 ? 1 : -1;
  }

  Ways seen_ways() const {
    std::vector<Neighbours> neighbours(roads_.paths.size());
    for (const PieceIndex i : topology_.pieces.indices()) {
      const std::size_t path = topology_.pieces[i].path;
      if (!may_be_carriageway(roads_.paths[path])) continue;
      const Polyline& line = lines_[i.value()];
      const double length = length_m(line);
      const int samples = std::max(1, static_cast<int>(length / sample_apart_m));
      for (int k = 0; k < samples; ++k) {
        const double s = (k + 0.5) * length / samples, half = std::min(0.5 * sample_apart_m, 0.5 * length);
        const Vec2 direction = normalized(point_at(line, s + half) - point_at(line, s - half));
        const int side = nearest_side(i, point_at(line, s), direction);
        Neighbours& seen = neighbours[path];
        ++seen.samples, seen.left += side > 0, seen.right += side < 0;
      }
    }
    Ways ways(roads_.paths.size(), 0);
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const auto [samples, left, right] = neighbours[i];
      if (samples == 0 || std::max(left, right) < least_share * samples ||
          std::min(left, right) > most_share_on_other_side * samples)
        continue;
      ways[i] = left > right ? oncoming_side_ : -oncoming_side_;
    }
    return ways;
  }

  /// Whether who drives the way that `ways` tells may come to a vertex by one of its ends, or leave it there.
  [[nodiscard]] bool may_leave(const Ways& ways, PieceEnd end) const { return may_pass(ways, end, 1); }
  [[nodiscard]] bool may_come(const Ways& ways, PieceEnd end) const { return may_pass(ways, end, -1); }
  [[nodiscard]] bool may_pass(const Ways& ways, PieceEnd end, int outwards) const {
    const std::size_t path = topology_.pieces[end.piece].path;
    const int way = roads_.paths[path].oneway == Oneway::forward ? 1 : ways[path];
    return way == 0 || way == (end.at_last ? -outwards : outwards);
  }

  /// Ways that go on from one-way ones without a junction.
  void follow(Ways& ways) const {
    for (bool more = true; more;) {
      more = false;
      for (const Vertex& vertex : topology_.vertices) {
        if (vertex.ends.size() != 2) continue;
        for (const std::size_t k : {0, 1}) {
          const PieceEnd from = vertex.ends[k], to = vertex.ends[1 - k];
          const std::size_t a = topology_.pieces[from.piece].path, b = topology_.pieces[to.piece].path;
          if (ways[a] == 0 || ways[b] != 0 || a == b || !may_be_carriageway(roads_.paths[b])) continue;
          ways[b] = from.at_last == to.at_last ? -ways[a] : ways[a];
          more = true;
        }
      }
    }
  }

  /// Makes ways two-way again to whose beginning nothing leads, or from whose end. Dead ends lie on the border.
  bool drop_closed(Ways& ways) const {
    bool dropped = false;
    for (const Vertex& vertex : topology_.vertices) {
      if (vertex.ends.size() < 2) continue;
      const bool left = std::ranges::any_of(vertex.ends, [&](PieceEnd end) { return may_leave(ways, end); });
      const bool entered = std::ranges::any_of(vertex.ends, [&](PieceEnd end) { return may_come(ways, end); });
      if (left && entered) continue;
      for (const PieceEnd end : vertex.ends) {
        int& way = ways[topology_.pieces[end.piece].path];
        dropped = dropped || way != 0;
        way = 0;
      }
    }
    return dropped;
  }

  const RoadNetwork& roads_;
  const Topology& topology_;
  int oncoming_side_;  ///< 1: to the left
  Table<PieceIndex, ChainIndex> chain_of_piece_;
  std::vector<Polyline> lines_;  ///< of the pieces
  SegmentIndex index_;
};

}  // namespace

bool has_oneway_tags(const RoadNetwork& roads) {
  return std::ranges::any_of(roads.paths,
                             [](const RoadPath& path) { return path.oneway != Oneway::no && !path.roundabout; });
}

RoadNetwork assume_carriageways(RoadNetwork roads, DrivingSide driving_side, Findings& findings) {
  Findings unused;  // told when the pieces are cut for good
  const Topology topology = build_topology(roads, driving_side, unused);
  const Ways ways = CarriagewayFinder(roads, topology, driving_side).run();
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (ways[i] == 0) continue;
    RoadPath& path = roads.paths[i];
    if (ways[i] < 0) turn_round(path);
    path.oneway = Oneway::forward;
    path.lanes_forward = path.lanes, path.lanes_backward = path.lanes_both_ways = 0;
    path.turn_backward.clear(), path.use_backward.clear(), path.widths_backward.clear();
    findings.push_back({Severity::warning, "network.carriageway_assumed",
                        fmt::format("way {}: runs beside another {} of the same name, and no way of the map is tagged "
                                    "oneway; took it as a carriageway",
                                    path.osm_id, path.highway),
                        path.nodes.front().p.x, path.nodes.front().p.y});
  }
  return roads;
}

}  // namespace orthodrive::network
