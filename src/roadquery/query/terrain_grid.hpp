// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights of the ground on a grid, as an ESRI ASCII grid holds them.

#include <optional>
#include <string>
#include <vector>

namespace roadquery {

/// Heights at (west + column spacing_m, south + row spacing_m), row by row from the south.
struct TerrainGrid {
  double west = 0.0, south = 0.0;  ///< of the first height, m
  double spacing_m = 1.0;
  int columns = 0, rows = 0;
  std::vector<float> z;  ///< m, NaN: unknown
};

struct TerrainPoint {
  double z = 0.0, dz_dx = 0.0, dz_dy = 0.0;
};

/// Bilinear. Half a spacing beyond the outer heights, to the border of their cells, the outer height goes on. Nothing
/// outside, and where one of the four heights is unknown.
[[nodiscard]] std::optional<TerrainPoint> evaluate(const TerrainGrid& grid, double x, double y);

/// Reads an ESRI ASCII grid: ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize, nodata_value (if
/// any), then the heights in m, row by row from the north. Throws std::runtime_error "file: line: what".
[[nodiscard]] TerrainGrid read_terrain_grid(const std::string& path);

}  // namespace roadquery
