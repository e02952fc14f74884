// SPDX-License-Identifier: Apache-2.0
// ESRI ASCII grids of the ground: read and asked.

#include <cmath>
#include <limits>
#include <stdexcept>

#include "memory_file.hpp"
#include "roadquery/query/terrain_grid.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::MemoryFile file;
  try {
    const roadquery::TerrainGrid grid = roadquery::read_terrain_grid(file.with(data, size));
    const double infinite = std::numeric_limits<double>::infinity();
    for (const double share : {-0.2, 0.0, 0.3, 1.0, 1e300, infinite, -infinite, std::nan("")}) {
      const double x = grid.west + share * grid.spacing_m * grid.columns;
      const double y = grid.south + share * grid.spacing_m * grid.rows;
      (void)roadquery::evaluate(grid, x, y), (void)roadquery::evaluate(grid, grid.west, y);
    }
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}
