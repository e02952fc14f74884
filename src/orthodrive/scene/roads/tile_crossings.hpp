// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where roads cross the borders of tiles.

#include <map>
#include <vector>

#include "orthodrive/scene/roads/road_level.hpp"

namespace orthodrive::scene {

/// Adds points on the borders of tiles between those where the lines of a level meet them, so that a chord across a
/// road stays within `tolerance_m` of its surface, crowns and all. The same for both tiles of a border.
/// `on_west`, `on_south`: as LevelLines has them, ascending.
void add_road_crossings(const RoadLevel& level, double tolerance_m, std::map<int, std::vector<double>>& on_west,
                        std::map<int, std::vector<double>>& on_south);

}  // namespace orthodrive::scene
