// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive::scene {

/// The photo over a square: mean of the valid pixels weighted by the area they share with each texel, at the photo's
/// own resolution or coarser (at most max_px a side). Texels without photo take the colour of their neighbourhood for a
/// few pixels, so that filtering at the edge does not draw a dark line, and are grey beyond. Empty if there is no photo
/// at all.
[[nodiscard]] Raster<std::uint8_t> tile_texture(const Photo& photo, const Box2& square, int max_px);

/// The label at the centre of each texel, label_nodata outside the map; texels as in tile_texture().
[[nodiscard]] Raster<std::uint8_t> tile_labels(const LabelMap& labels, const Box2& square, int max_px);

}  // namespace orthodrive::scene
