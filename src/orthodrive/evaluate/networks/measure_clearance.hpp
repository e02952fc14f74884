// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where roads cross on different levels, for evaluate_network.

#include "orthodrive/evaluate/networks/evaluate_network.hpp"
#include "roadquery/roads/road_ends.hpp"

namespace orthodrive::evaluate {

/// Sets the crossings and min_clearance_m.
void measure_clearance(const roadquery::RoadMap& map, const roadquery::RoadsById& by_id, NetworkScores& scores);

}  // namespace orthodrive::evaluate
