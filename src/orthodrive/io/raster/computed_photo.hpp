// SPDX-License-Identifier: Apache-2.0
#pragma once
// A photo whose pixels are computed of another one's when GDAL asks for them. Internal to io.

#include <functional>

#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {

/// A window of pixels of a raster, inside it.
struct ComputedWindow {
  int col = 0, row = 0, width = 0, height = 0;
};
/// Writes band `band` (1..) of the window, row by row. False where the source cannot be read.
using ComputeBand = std::function<bool(int band, const ComputedWindow& window, std::uint8_t* pixels)>;

/// On the grid of `like`, 8 bit, bands red, green, blue and, if there are four, alpha. What `compute` uses must outlive
/// the photo; it may own it.
[[nodiscard]] DatasetPtr computed_photo(GDALDataset& like, int bands, ComputeBand compute);

/// One band of 8 bit; false with GDAL's error set where it cannot be read.
[[nodiscard]] bool read_band(GDALRasterBand& band, const ComputedWindow& window, std::uint8_t* pixels);

}  // namespace orthodrive::io
