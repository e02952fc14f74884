// SPDX-License-Identifier: Apache-2.0
#pragma once
// SLIC superpixels of a photo (Achanta et al., SLIC Superpixels Compared to State-of-the-art Superpixel Methods, 2012)
// and what the forests see of each: colour, texture and how it differs from its neighbours.

#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/geo/raster.hpp"

namespace orthodrive {

struct SuperpixelOptions {
  double size_m = 2.0;  ///< edge of a superpixel; at least 6 pixels are taken, below that SLIC has no freedom left
  double ruler = 15.0;  ///< weight of nearness against colour (8-bit Lab): larger makes squarer superpixels
  int iterations = 6;   ///< of the clustering; the reference implementation takes 10, the labels hardly change after 5
  double texture_m = 5.0;  ///< edge of the window of the coarse texture features
};

/// Edge of a superpixel in pixels.
[[nodiscard]] int superpixel_px(const SuperpixelOptions& options, double gsd_m);

constexpr int superpixel_features = 21;

struct Superpixels {
  Raster<std::int32_t> labels;  ///< 0 .. count - 1, the superpixel of every pixel
  int count = 0;
  std::vector<float> features;       ///< superpixel_features a superpixel
  std::vector<std::int32_t> pixels;  ///< valid pixels of each

  [[nodiscard]] std::span<const float> features_of(int superpixel) const {
    return std::span(features).subspan(static_cast<std::size_t>(superpixel) * superpixel_features, superpixel_features);
  }
};

/// `rgb` has 3 channels; `valid` is empty (all are) or 0 where a pixel means nothing: those count in no feature.
/// One thread; memory is some 60 bytes a pixel.
[[nodiscard]] Superpixels make_superpixels(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid,
                                           double gsd_m, const SuperpixelOptions& options);

}  // namespace orthodrive
