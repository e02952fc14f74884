// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which road lies across from a place?

#include <cstddef>
#include <optional>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::evaluate {

/// A place on a path, seen from a point beside it.
struct Across {
  std::size_t path = 0, segment = 0;  ///< segment = index of the node before
  double fraction = 0.0;              ///< 0..1 along the segment
  double offset_m = 0.0;              ///< of the path from the point, positive to the left of the direction asked with
  bool same_direction = true;         ///< as the direction asked with
};

/// A number of a node, between the two nodes of the place.
[[nodiscard]] inline double interpolate(const RoadNetwork& roads, const Across& at, double RoadNode::*number) {
  const RoadNode *before = &roads.paths[at.path].nodes[at.segment], *after = before + 1;
  return before->*number + at.fraction * (after->*number - before->*number);
}

class RoadsAcross {
 public:
  /// Keeps a reference to `roads`.
  explicit RoadsAcross(const RoadNetwork& roads);

  struct Query {
    Vec2 p, direction;              ///< direction is a unit vector
    double reach_m = 15.0;          ///< look so far to both sides
    double max_angle_rad = 0.5236;  ///< 30 degrees: lines that cross are not the same road
    std::optional<int> layer;       ///< only paths of that layer
  };
  /// The nearest path that the perpendicular through p meets.
  [[nodiscard]] std::optional<Across> find(const Query& query) const;

 private:
  const RoadNetwork& roads_;
  SegmentIndex index_;  // of the centre lines
};

}  // namespace orthodrive::evaluate
