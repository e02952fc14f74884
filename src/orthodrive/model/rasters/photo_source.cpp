// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/photo_source.hpp"

#include <cstring>

namespace orthodrive {

PhotoSource source_of(const Photo& photo) {
  return {
      photo.crs, photo.frame, [&photo](const PixelBox& box) {
        PhotoWindow window{Raster<std::uint8_t>(box.width, box.height, 3), Raster<std::uint8_t>(box.width, box.height)};
        const PixelBox inside = intersection(box, pixels_of(photo.frame));
        if (inside.empty()) return window;
        const int left = static_cast<int>(inside.col - box.col), top = static_cast<int>(inside.row - box.row);
        const int col = static_cast<int>(inside.col), row = static_cast<int>(inside.row);
        const auto pixels = static_cast<std::size_t>(inside.width);
        for (int i = 0; i < inside.height; ++i) {
          std::memcpy(&window.rgb.at(left, top + i), &photo.rgb.at(col, row + i), 3 * pixels);
          std::memcpy(&window.valid.at(left, top + i), &photo.valid.at(col, row + i), pixels);
        }
        return window;
      }};
}

}  // namespace orthodrive
