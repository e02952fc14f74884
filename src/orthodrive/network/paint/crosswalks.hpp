// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where people walk across a road.

#include <vector>

#include "orthodrive/network/line/network_plan.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Along the road, m: FGSV, R-FGUE 2001 asks for 3 m and recommends 4 m.
inline constexpr double crosswalk_m = 4.0;

/// Crossings that OSM has on the nodes of the roads become crosswalks (OpenDRIVE 1.8, 13.14.3): "zebra" where they are
/// marked, "pedestrian" at traffic lights, "virtual" where nothing is painted. On the road that the node lies on,
/// across its carriageway; inside a junction on the connecting road that follows the way best, as wide as the way.
/// `straight`: ids of the connecting roads that go straight on, ascending. Crossings at a vertex of a junction have no
/// place of their own and are left out, like those that no road runs under.
void add_crosswalks(const NetworkPlan& plan, const std::vector<int>& straight, roadquery::RoadMap& map);

}  // namespace orthodrive::network
