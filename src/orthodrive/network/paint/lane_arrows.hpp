// SPDX-License-Identifier: Apache-2.0
#pragma once
// Arrows on lanes, as turn:lanes has them.

#include <vector>

#include "orthodrive/network/line/network_plan.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Road marks "arrowLeft", "arrowStraightRight" ... (OpenDRIVE 1.8, 13.14.8) in the middle of the lanes that lead into
/// junctions, where turn:lanes says which lane turns where: 4 m behind the waiting line, or the road's end, and once
/// more 25 m further back. 5 m long, 7.5 m from 70 km/h on (RMS-1 1993). Lanes narrower than 2 m there have none.
void add_lane_arrows(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends,
                     roadquery::RoadMap& map);

}  // namespace orthodrive::network
