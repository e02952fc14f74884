// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/finish_road.hpp"

namespace roadquery {

/// Lane sections with singleSide="true" (1.4 - 1.8, 11.3) say what changes on one side: on a side that they have no
/// element of, the lanes of the section before go on. The road's sections are in order.
void continue_sides(Road& road, const std::vector<RoadParts::SingleSide>& single_sides);

}  // namespace roadquery
