// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far the nearest edge of the photo is: road borders should lie on edges.
//
// The edge detector of the reference (thesis sec. 3.2.3): Canny with several thresholds, merged. Canny's edges at a
// high threshold are edges at a low one too, so a plain union would be the lowest threshold alone. We merge the
// distances instead: the mean over the thresholds of the distance to the nearest edge, each capped. Strong edges
// attract from the cap, weak ones less.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"

namespace orthodrive {

struct EdgeDistanceOptions {
  /// Upper thresholds on the gradient of the grey value (Sobel, 0..1443); the lower is half of it. Kerbs are faint: at
  /// 160 hardly any was an edge on the synthetic villages.
  std::vector<double> thresholds{20.0, 40.0, 80.0};
  double cap_m = 2.0;  ///< farther edges are all as far
};

/// One channel a pixel: 0 on an edge at all thresholds, 255 = cap_m. Where `valid` (may be empty) is 0, and beside it,
/// there are no edges. Throws OptionError for no threshold or a cap that is not positive.
[[nodiscard]] Raster<std::uint8_t> edge_distance(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid,
                                                 double gsd_m, const EdgeDistanceOptions& options = {});

/// The same for a box of a photo, from the tiles of a fixed grid that it touches: a pixel is the same in every box.
[[nodiscard]] Raster<std::uint8_t> edge_distance(const PhotoSource& photo, const PixelBox& box,
                                                 const EdgeDistanceOptions& options = {});

}  // namespace orthodrive
