// SPDX-License-Identifier: Apache-2.0
#pragma once
// OSM's nodes are far apart on straight roads; heights and networks want a node every few metres.

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Every segment longer than `step_m` is cut into equal parts of at most that. The lines stay as they are, all nodes
/// stay; new ones have no osm_node, lie on the segment and have values between those at its ends.
[[nodiscard]] RoadNetwork with_nodes_every(RoadNetwork roads, double step_m);

}  // namespace orthodrive
