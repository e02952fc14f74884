// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where road lines cross in plan without meeting: bridges over roads, and places where OSM lacks a node.

#include <cstddef>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct PathCrossing {
  std::size_t path_a = 0, path_b = 0;         ///< path_a <= path_b
  std::size_t segment_a = 0, segment_b = 0;   ///< index of the node before the crossing
  double fraction_a = 0.0, fraction_b = 0.0;  ///< 0..1 along those segments
  Vec2 p;
};

/// Crossings of segments that share no osm_node, ordered by (path_a, segment_a, path_b, segment_b).
[[nodiscard]] std::vector<PathCrossing> find_crossings(const RoadNetwork& roads);

}  // namespace orthodrive
