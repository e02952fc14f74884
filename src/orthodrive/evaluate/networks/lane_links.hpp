// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where lanes lead, for evaluate_network.

#include "orthodrive/evaluate/networks/evaluate_network.hpp"
#include "roadquery/roads/road_ends.hpp"

namespace orthodrive::evaluate {

/// Sets lane_link_errors, dead lanes and min_lane_width_m.
void check_lanes(const roadquery::RoadMap& map, const roadquery::RoadsById& by_id, NetworkScores& scores);

}  // namespace orthodrive::evaluate
