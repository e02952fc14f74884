// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shortest ways from one place on a road to another, in the direction of driving: the transitions of match_log.

#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::elevate {

/// A place on a road, driven in one direction.
struct DirectedPlace {
  std::size_t path = 0;
  double s_m = 0.0, offset_m = 0.0;
  bool forward = true;
};

/// A stretch of one path that was driven; s_to < s_from against the path's direction.
struct DrivenStretch {
  std::size_t path;
  double s_from, s_to;
};

/// The network as a graph: vertices are the nodes that paths share.
class WaysOnRoads {
 public:
  /// Keeps a reference to the roads.
  explicit WaysOnRoads(const RoadNetwork& roads);

  struct Reached {
    double way_m = std::numeric_limits<double>::infinity();
    std::optional<std::size_t> before;  ///< vertex; none: straight from the start
    DrivenStretch stretch{};            ///< that led here
  };
  /// [vertex]
  using Reach = std::map<std::size_t, Reached>;

  /// All vertices within reach when driving on from a place (Dijkstra). No one-way road is driven against its
  /// direction, no way turns on the spot; only the last stretch, from a vertex to a place, may go back where the way
  /// came from.
  [[nodiscard]] Reach reach_from(const DirectedPlace& from, double limit_m) const;
  /// Length of the way between two places, `reach` being that of `from`; infinity when it is out of reach. A place up
  /// to 5 m behind on the same path counts as its distance: positions are noisy.
  [[nodiscard]] double way_m(const DirectedPlace& from, const DirectedPlace& to, const Reach& reach) const;
  /// The stretches of that way, in order.
  [[nodiscard]] std::vector<DrivenStretch> stretches(const DirectedPlace& from, const DirectedPlace& to,
                                                     const Reach& reach) const;

 private:
  /// Where a path meets others.
  struct Stop {
    double s_m;
    std::size_t vertex;
  };
  struct Visit {
    std::size_t path, stop;  // index in stops_[path]
  };
  [[nodiscard]] const Stop* stop_after(const DirectedPlace& from) const;
  [[nodiscard]] const Stop* stop_before(const DirectedPlace& to) const;

  const RoadNetwork& roads_;
  std::vector<std::vector<Stop>> stops_;    // [path], ascending
  std::vector<std::vector<Visit>> visits_;  // [vertex]
};

}  // namespace orthodrive::elevate
