// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where lanes lead, for evaluate_network.

#include "orthodrive/evaluate/networks/evaluate_network.hpp"
#include "orthodrive/evaluate/networks/road_ends.hpp"

namespace orthodrive::evaluate {

/// Sets lane_link_errors, dead lanes and min_lane_width_m; adds to broken_links.
void check_lanes(const roadquery::RoadMap& map, const RoadsById& by_id, NetworkScores& scores);

}  // namespace orthodrive::evaluate
