// SPDX-License-Identifier: Apache-2.0
#pragma once
// A photo that is read window by window: mosaics do not fit in memory.

#include <cstdint>
#include <functional>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

struct PhotoWindow {
  Raster<std::uint8_t> rgb;    ///< 3 channels; means nothing where valid is 0
  Raster<std::uint8_t> valid;  ///< 1 channel, 0 or 1; 0 beyond the frame
};

struct PhotoSource {
  Crs crs;
  GridFrame frame;
  /// Any box, also beyond the frame. From several threads at once. A pixel is the same in every box that has it.
  std::function<PhotoWindow(const PixelBox&)> read;
};

/// The photo must outlive the source.
[[nodiscard]] PhotoSource source_of(const Photo& photo);

}  // namespace orthodrive
