// SPDX-License-Identifier: Apache-2.0
#pragma once
// What other cameras, seasons, suns and archives do to a photo. A network that learns from few places sees them as if
// they were others (domain randomisation, Tobin et al., 2017). Labels stay as they are.

#include <array>
#include <cstdint>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// value / 255 -> gain * (contrast * (value - 1/2) + 1/2) ^ gamma, after saturation and hue around the grey axis.
struct ColorChange {
  double saturation = 1.0;  ///< 0: grey
  double hue_rad = 0.0;
  double contrast = 1.0, gamma = 1.0;
  std::array<double, 3> gain{1.0, 1.0, 1.0};
};
void change_colors(Raster<std::uint8_t>& rgb, const ColorChange& change);

/// Green becomes the brown of dry grass and bare trees: of what green has above the mean of red and blue, `share` goes
/// and half of that comes to red.
void fade_green(Raster<std::uint8_t>& rgb, double share);

/// Mixes in `density` of bluish air light.
void add_haze(Raster<std::uint8_t>& rgb, double density);

/// 1 2 1 binomial, both ways.
void blur(Raster<std::uint8_t>& rgb);

/// Adds `amount` of the difference to the blurred photo.
void sharpen(Raster<std::uint8_t>& rgb, double amount);

/// Cells of 8 x 8 px lose what JPEG of that quality (1 to 100, the tables of ITU-T T.81, annex K) loses: luminance in
/// all cells, chrominance in cells of 16 x 16 px as cameras store it.
void compress(Raster<std::uint8_t>& rgb, int quality);

/// Within the parallelogram at `corner`, spanned by two sides in pixels, only `light` of the sun's light is left; blue
/// keeps more of it, because the sky still shines there.
struct Shadow {
  Vec2 corner, side, reach;
  double light = 0.5;
};
void cast_shadow(Raster<std::uint8_t>& rgb, const Shadow& shadow);

/// All of these at random; `strength` 1 is as far as photos of other countries differ, 0 nothing.
void disturb_domain(Raster<std::uint8_t>& rgb, double strength, Random& random);

}  // namespace orthodrive
