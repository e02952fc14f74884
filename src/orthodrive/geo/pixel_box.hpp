// SPDX-License-Identifier: Apache-2.0
#pragma once
// A rectangle of pixels of a grid. Absolute: it may reach beyond the grid on any side.

#include <algorithm>
#include <cstdint>

#include "orthodrive/geo/raster.hpp"

namespace orthodrive {

struct PixelBox {
  std::int64_t col = 0, row = 0;  ///< the north-western pixel
  int width = 0, height = 0;

  [[nodiscard]] std::int64_t end_col() const { return col + width; }
  [[nodiscard]] std::int64_t end_row() const { return row + height; }
  [[nodiscard]] bool empty() const { return width <= 0 || height <= 0; }
  [[nodiscard]] PixelBox grown(int px) const { return {col - px, row - px, width + 2 * px, height + 2 * px}; }
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

[[nodiscard]] inline PixelBox pixels_of(const GridFrame& frame) { return {0, 0, frame.width, frame.height}; }

/// Empty when they have no pixel in common.
[[nodiscard]] inline PixelBox intersection(const PixelBox& a, const PixelBox& b) {
  const std::int64_t col = std::max(a.col, b.col), row = std::max(a.row, b.row);
  return {col, row, static_cast<int>(std::max<std::int64_t>(0, std::min(a.end_col(), b.end_col()) - col)),
          static_cast<int>(std::max<std::int64_t>(0, std::min(a.end_row(), b.end_row()) - row))};
}

}  // namespace orthodrive
