// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interpolation of a height grid between pixel centres.

#include <vector>

#include "orthodrive/model/rasters/raster_source.hpp"

namespace orthodrive {

enum class HeightSampling { bilinear, cubic };

/// Bilinear between the four nearest pixel centres; beyond the outermost centres (by up to one pixel) the border value
/// goes on. NaN when a pixel with weight is nodata or p is outside.
[[nodiscard]] double sample_bilinear(const HeightGrid& grid, Vec2 p);
/// Cubic convolution, a = -0.5 (Keys 1981, eq. 4); falls back to bilinear where the 4 x 4 pixels are not all there.
[[nodiscard]] double sample_cubic(const HeightGrid& grid, Vec2 p);
[[nodiscard]] double sample_height(const HeightGrid& grid, Vec2 p, HeightSampling sampling);

/// One grid over `box` at the smallest GSD of the given ones, window by window: each pixel takes the first grid (best
/// first) that has a height there (cubic), NaN where none has. A single grid stays as it is. All share one CRS; at
/// least one is given. The grids must outlive the source.
[[nodiscard]] HeightSource merged_source(const std::vector<HeightGrid>& best_first, const Box2& box);

}  // namespace orthodrive
