// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/terrain_grid_io.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>

#include "orthodrive/core/atomic_file.hpp"

namespace orthodrive::io {

void write_terrain_grid(const std::filesystem::path& path, const HeightGrid& grid) {
  const GridFrame& f = grid.frame;
  std::string text = fmt::format("ncols {}\nnrows {}\nxllcorner {}\nyllcorner {}\ncellsize {}\nNODATA_value -9999\n",
                                 f.width, f.height, f.bounds().min_x, f.bounds().min_y, f.gsd_m);
  auto out = std::back_inserter(text);
  for (int row = 0; row < f.height; ++row)
    for (int col = 0; col < f.width; ++col) {
      const float z = grid.height_m.at(col, row);
      const char end = col + 1 < f.width ? ' ' : '\n';
      if (std::isnan(z))
        fmt::format_to(out, "-9999{}", end);
      else
        fmt::format_to(out, "{:.3f}{}", z, end);
    }
  write_text_file(path, text);
}

}  // namespace orthodrive::io
