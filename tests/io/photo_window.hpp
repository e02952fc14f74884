// SPDX-License-Identifier: Apache-2.0
#pragma once
// A window of a photo against the photo read as a whole.

#include <gtest/gtest.h>

#include "orthodrive/model/rasters/photo_source.hpp"

namespace orthodrive {

/// The window shows what `whole` shows there, and nothing beyond it.
inline void expect_window_of(const Photo& whole, const PixelBox& box, const PhotoWindow& window) {
  ASSERT_EQ(std::pair(window.rgb.width, window.rgb.height), std::pair(box.width, box.height));
  std::size_t different = 0;
  for (int row = 0; row < box.height; ++row)
    for (int col = 0; col < box.width; ++col) {
      const int at_col = static_cast<int>(box.col) + col, at_row = static_cast<int>(box.row) + row;
      const bool inside = whole.valid.inside(at_col, at_row);
      different += window.valid.at(col, row) != (inside ? whole.valid.at(at_col, at_row) : 0) ? 1 : 0;
      for (int c = 0; c < 3 && inside; ++c)
        different += window.rgb.at(col, row, c) != whole.rgb.at(at_col, at_row, c) ? 1 : 0;
    }
  EXPECT_EQ(different, 0u) << box.col << ' ' << box.row << ' ' << box.width << ' ' << box.height;
}

}  // namespace orthodrive
