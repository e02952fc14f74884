#pragma once
// A photo at another scale.

#include "orthodrive/model/rasters.hpp"

namespace orthodrive {

/// The value of a pixel outside the photo, for networks: zero after normalisation.
constexpr std::uint8_t no_photo_value = 128;

/// Onto the covering grid of that GSD: area average when it gets coarser by more than a quarter, else bilinear.
/// Pixels without photo are set to no_photo_value. The photo itself when the scale is already right.
[[nodiscard]] Photo resample_photo(const Photo& photo, double gsd_m, int threads = 0);

}  // namespace orthodrive
