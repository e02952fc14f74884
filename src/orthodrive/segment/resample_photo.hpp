// SPDX-License-Identifier: Apache-2.0
#pragma once
// A photo at another scale.

#include "orthodrive/model/rasters/photo_source.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

/// The value of a pixel outside the photo, for networks: zero after normalisation.
constexpr std::uint8_t no_photo_value = 128;

/// The frame itself when its scale is already right, else the covering grid of that GSD.
[[nodiscard]] GridFrame resampled_frame(const GridFrame& frame, double gsd_m);

/// Onto the resampled frame: area average when it gets coarser by more than a quarter, else bilinear; where less than
/// half of what a pixel averages is photo, there is none. Pixels without photo are set to no_photo_value. Weights come
/// from the absolute pixel, so every window gets the same bytes.
[[nodiscard]] PhotoSource resample_source(PhotoSource photo, double gsd_m);
/// Likewise onto any frame.
[[nodiscard]] PhotoSource resample_source(PhotoSource photo, const GridFrame& frame);

/// The same for a photo in memory.
[[nodiscard]] Photo resample_photo(const Photo& photo, double gsd_m, int threads = 0);

}  // namespace orthodrive
