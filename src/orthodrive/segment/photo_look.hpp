// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a photo looks like as a whole: networks know photos in natural colours, by day, without snow.

#include <cstdint>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// Counts of pixels, so that parts of a photo add up in any order. Luminance is (r + 2 g + b) / 4, chroma the largest
/// channel minus the smallest, 0..255.
struct PhotoLook {
  std::int64_t pixels = 0, luminance = 0, chroma = 0;  ///< the latter two summed
  std::int64_t white = 0;                              ///< luminance above 190, chroma below 30: snow, glare
  std::int64_t red = 0;                                ///< red a third above green and blue, as vegetation in infrared

  PhotoLook& operator+=(const PhotoLook& other);
};
template <typename Archive>
void fields(Archive& archive, PhotoLook& look) {
  archive(look.pixels, look.luminance, look.chroma, look.white, look.red);
}
/// Of the valid pixels (not 0) of a part of `rgb`: width x height from column `left`, row `top`.
[[nodiscard]] PhotoLook look_of(const Raster<std::uint8_t>& rgb, const Raster<std::uint8_t>& valid, int left, int top,
                                int width, int height);

/// Warnings segment.gray_photo, segment.dark_photo, segment.white_photo, segment.infrared_photo at `place`. Limits are
/// far from what the photos of six regions show (docs/segment.md).
[[nodiscard]] Findings judge_look(const PhotoLook& look, Vec2 place);

}  // namespace orthodrive
