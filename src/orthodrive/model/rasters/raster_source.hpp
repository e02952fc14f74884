// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rasters that are read window by window: those of a country do not fit in memory.

#include <cstdint>
#include <functional>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

/// Heights in metres at pixel centres, NaN where there is none.
struct HeightSource {
  Crs crs;
  GridFrame frame;
  /// Any box inside the frame. From several threads at once. A pixel is the same in every box that has it.
  std::function<Raster<float>(const PixelBox&)> read;
};

/// Classes, label_nodata where there is no photo. As HeightSource.
struct LabelSource {
  Crs crs;
  GridFrame frame;
  ClassTable classes;
  std::function<Raster<std::uint8_t>(const PixelBox&)> read;
};

/// What they are made of must outlive the sources.
[[nodiscard]] HeightSource source_of(const HeightGrid& grid);
[[nodiscard]] LabelSource source_of(const LabelMap& labels);

/// The pixels of a grid that a box touches; empty where it lies beside the grid.
[[nodiscard]] PixelBox pixels_in(const GridFrame& frame, const Box2& box);
/// The grid of some of its pixels.
[[nodiscard]] GridFrame part_of(const GridFrame& frame, const PixelBox& box);

/// What a source has in a box.
[[nodiscard]] Photo window_of(const PhotoSource& source, const Box2& box);
[[nodiscard]] LabelMap window_of(const LabelSource& source, const Box2& box);

}  // namespace orthodrive
