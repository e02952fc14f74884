// SPDX-License-Identifier: Apache-2.0
#pragma once
// Terrain for simulators: roadquery/terrain_grid.hpp reads it.

#include <filesystem>

#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive::io {

/// ESRI ASCII grid: heights in m with three decimals, -9999 where there is none.
void write_terrain_grid(const std::filesystem::path& path, const HeightGrid& grid);

}  // namespace orthodrive::io
