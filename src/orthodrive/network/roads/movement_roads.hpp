// SPDX-License-Identifier: Apache-2.0
#pragma once
// The road of a movement through a junction.

#include "orthodrive/network/roads/movements.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Without its id and junction. `in`, `out`: the gates that it leads from and to; `level`: the junction's.
[[nodiscard]] roadquery::Road connecting_road(const NetworkPlan& plan, const roadquery::RoadMap& map,
                                              const std::vector<JunctionEnd>& ends, const Movement& m, int level,
                                              Gate in, Gate out);

}  // namespace orthodrive::network
