// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fixed grid of tiles in which the photo is worked on, so that no result depends on which window was asked for.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/pixel_box.hpp"

namespace orthodrive::baselines {

constexpr int mrf_tile_px = 512;

/// First pixel of the tile that holds pixel `at`, along one axis.
[[nodiscard]] constexpr std::int64_t tile_start(std::int64_t at) {
  return (at >= 0 ? at / mrf_tile_px : -((-at + mrf_tile_px - 1) / mrf_tile_px)) * mrf_tile_px;
}

/// Tiles that have a pixel of the box, row by row.
[[nodiscard]] inline std::vector<PixelBox> tiles_of(const PixelBox& box) {
  std::vector<PixelBox> tiles;
  for (std::int64_t row = tile_start(box.row); row < box.end_row(); row += mrf_tile_px)
    for (std::int64_t col = tile_start(box.col); col < box.end_col(); col += mrf_tile_px)
      tiles.push_back({col, row, mrf_tile_px, mrf_tile_px});
  return tiles;
}

}  // namespace orthodrive::baselines
