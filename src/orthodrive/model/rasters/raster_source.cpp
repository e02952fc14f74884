// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/raster_source.hpp"

#include <cmath>

namespace orthodrive {
namespace {

template <typename T>
Raster<T> cut_out(const Raster<T>& raster, const PixelBox& box) {
  Raster<T> part(box.width, box.height);
  for (int row = 0; row < box.height; ++row)
    for (int col = 0; col < box.width; ++col)
      part.at(col, row) = raster.at(static_cast<int>(box.col) + col, static_cast<int>(box.row) + row);
  return part;
}

}  // namespace

HeightSource source_of(const HeightGrid& grid) {
  return {grid.crs, grid.frame, [&grid](const PixelBox& box) { return cut_out(grid.height_m, box); }};
}

LabelSource source_of(const LabelMap& labels) {
  return {labels.crs, labels.frame, labels.classes,
          [&labels](const PixelBox& box) { return cut_out(labels.labels, box); }};
}

PixelBox pixels_in(const GridFrame& frame, const Box2& box) {
  const Vec2 low = frame.pixel_from_world({box.min_x, box.max_y}),
             high = frame.pixel_from_world({box.max_x, box.min_y});
  const auto clamped = [](double v, int limit) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(limit)));
  };
  const int west = clamped(std::floor(low.x), frame.width), north = clamped(std::floor(low.y), frame.height);
  const int east = clamped(std::ceil(high.x), frame.width), south = clamped(std::ceil(high.y), frame.height);
  return {west, north, std::max(0, east - west), std::max(0, south - north)};
}

GridFrame part_of(const GridFrame& frame, const PixelBox& box) {
  GridFrame part = frame;
  part.width = box.width, part.height = box.height;
  part.first_col += static_cast<int>(box.col), part.first_row += static_cast<int>(box.row);
  return part;
}

Photo window_of(const PhotoSource& source, const Box2& box) {
  const PixelBox pixels = pixels_in(source.frame, box);
  Photo photo{.crs = source.crs, .frame = part_of(source.frame, pixels)};
  if (pixels.empty()) return photo;
  PhotoWindow window = source.read(pixels);
  photo.rgb = std::move(window.rgb), photo.valid = std::move(window.valid);
  return photo;
}

LabelMap window_of(const LabelSource& source, const Box2& box) {
  const PixelBox pixels = pixels_in(source.frame, box);
  LabelMap labels{source.crs, part_of(source.frame, pixels), {}, source.classes};
  if (!pixels.empty()) labels.labels = source.read(pixels);
  return labels;
}

}  // namespace orthodrive
