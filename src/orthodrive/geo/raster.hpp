// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters as values, and the north-up grid that places one in the site CRS.

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// Row-major, row 0 in the north; channels interleaved (RGBRGB...).
template <typename T>
struct Raster {
  int width = 0, height = 0, channels = 1;
  std::vector<T> data;

  Raster() = default;
  Raster(int width, int height, int channels = 1, T fill = T{})
      : width(width),
        height(height),
        channels(channels),
        data(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels),
             fill) {}

  [[nodiscard]] std::size_t index(int col, int row, int channel = 0) const {
    assert(col >= 0 && col < width && row >= 0 && row < height && channel >= 0 && channel < channels);
    return (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(col)) *
               static_cast<std::size_t>(channels) +
           static_cast<std::size_t>(channel);
  }
  [[nodiscard]] T& at(int col, int row, int channel = 0) { return data[index(col, row, channel)]; }
  [[nodiscard]] const T& at(int col, int row, int channel = 0) const { return data[index(col, row, channel)]; }
  [[nodiscard]] bool inside(int col, int row) const { return col >= 0 && col < width && row >= 0 && row < height; }
  [[nodiscard]] bool empty() const { return data.empty(); }
};

/// North-up grid of square pixels. Continuous pixel coordinates have (0,0) at the outer north-west corner of the first
/// pixel, so the centre of pixel (col,row) is at (col+0.5, row+0.5).
struct GridFrame {
  double west_m = 0.0, north_m = 0.0;  ///< outer north-west corner, site CRS
  double gsd_m = 1.0;                  ///< ground sampling distance: edge of a pixel
  int width = 0, height = 0;
  /// Of a window: its first pixel in the whole grid, whose corner west_m and north_m stay. A place then has the same
  /// pixel in every window, to the last bit.
  int first_col = 0, first_row = 0;

  [[nodiscard]] Vec2 world_from_pixel(double col, double row) const {
    return {west_m + (col + first_col) * gsd_m, north_m - (row + first_row) * gsd_m};
  }
  [[nodiscard]] Vec2 pixel_from_world(Vec2 p) const {
    return {(p.x - west_m) / gsd_m - first_col, (north_m - p.y) / gsd_m - first_row};
  }
  [[nodiscard]] Vec2 center_of(int col, int row) const { return world_from_pixel(col + 0.5, row + 0.5); }
  [[nodiscard]] Box2 bounds() const {
    const Vec2 north_west = world_from_pixel(0, 0), south_east = world_from_pixel(width, height);
    return {north_west.x, south_east.y, south_east.x, north_west.y};
  }
  friend bool operator==(const GridFrame&, const GridFrame&) = default;
};

/// The smallest grid of that GSD whose edges are multiples of the GSD and that covers the box.
[[nodiscard]] inline GridFrame covering_grid(const Box2& box, double gsd_m) {
  const double west = std::floor(box.min_x / gsd_m), north = std::ceil(box.max_y / gsd_m);
  return {west * gsd_m, north * gsd_m, gsd_m, static_cast<int>(std::ceil(box.max_x / gsd_m - west)),
          static_cast<int>(std::ceil(north - box.min_y / gsd_m))};
}

}  // namespace orthodrive
