// SPDX-License-Identifier: Apache-2.0
#pragma once
// Common nodes where OSM lacks them: ways that cross on one level.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::network {

/// Where two ways of one layer, neither or both on a bridge or in a tunnel, cross at nearly one height without a common
/// node, cars drive over one pavement: both get a node there, and so a junction with one surface. As OSM does not
/// connect them nobody turns there: each gets a restriction to its own way. Crossings within 20 m along both ways of a
/// node that they share are errors of the lines and stay; within 150 m where they cross at less than 30 degrees.
/// Finding network.crossing_without_node for each.
[[nodiscard]] RoadNetwork join_crossings(RoadNetwork roads, Findings& findings);

}  // namespace orthodrive::network
