// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a network says of the map's roads, as CSV: alignment.csv.

#include <filesystem>

#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::io {

/// Columns osm_id, part, s_m, east_m, north_m, sigma_m, half_width_m, sigma_half_width_m; one row a place of which
/// something is said, in the order of the paths.
void write_alignment(const std::filesystem::path& path, const RoadNetwork& roads, const RoadAlignment& alignment);

/// For the paths of `roads`; those that the file does not have get none. Throws InputError with the line that is wrong.
[[nodiscard]] RoadAlignment read_alignment(const std::filesystem::path& path, const RoadNetwork& roads);

}  // namespace orthodrive::io
