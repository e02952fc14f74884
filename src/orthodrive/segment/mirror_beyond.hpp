// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a network sees beyond the edges of a photo: the photo again, mirrored there. Ronneberger et al., U-Net, 2015.

#include <cstdint>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"

namespace orthodrive {

/// Of `count` pixels in a row the one that pixel `index` shows, which may lie beyond them: -1 shows 0, -2 shows 1,
/// `count` shows `count` - 1, and so on, to and fro.
[[nodiscard]] std::int64_t mirrored_index(std::int64_t index, std::int64_t count);

/// The pixels of `box`, whose part in the frame is `inside`, out of those of that part. What is mirrored must lie in
/// it: so it does where `box` is a box in the frame, grown on all sides alike.
[[nodiscard]] Raster<std::uint8_t> mirror_beyond(Raster<std::uint8_t> inside, const PixelBox& box,
                                                 const GridFrame& frame);

/// Likewise of a map raster (map_alignment.hpp): its vectors are mirrored, too.
[[nodiscard]] Raster<std::uint8_t> mirror_map_beyond(Raster<std::uint8_t> inside, const PixelBox& box,
                                                     const GridFrame& frame);

/// East and west changed.
[[nodiscard]] Raster<std::uint8_t> mirrored(Raster<std::uint8_t> raster);
/// Likewise of a map raster; none stays none.
[[nodiscard]] Raster<std::uint8_t> mirrored_map(Raster<std::uint8_t> raster);

}  // namespace orthodrive
