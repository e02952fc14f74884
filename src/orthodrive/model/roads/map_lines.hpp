// SPDX-License-Identifier: Apache-2.0
#pragma once
// OSM's roads as a network sees them. Apart from map_alignment.hpp, which training without OSM needs, too.

#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// The centre lines of OSM's roads with half their widths; without tunnels, which no photo shows.
[[nodiscard]] std::vector<RoadLine> road_lines(const RoadNetwork& roads);
[[nodiscard]] MapLines map_lines(const RoadNetwork& roads);

}  // namespace orthodrive
