// SPDX-License-Identifier: Apache-2.0
#pragma once
// The nodes of signs, after a method has laid other nodes along the roads.

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Signs of the map at nodes that are no longer on a road: the nearest node without an id on the same path gets the id.
/// Nothing moves. `moved` has the paths of `map` by osm_id and part, and gets its signs.
void keep_signs(const RoadNetwork& map, RoadNetwork& moved);

}  // namespace orthodrive
