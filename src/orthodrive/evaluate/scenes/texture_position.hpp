// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far the photo on a tile lies from where the photo itself has it.

#include <cstddef>
#include <functional>
#include <optional>

#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/scene.hpp"

namespace orthodrive {

/// Brightness of the photo, 0 to 255, at a place of the site CRS; nothing where it shows nothing.
using BrightnessAt = std::function<std::optional<double>(Vec2)>;

struct TexturePosition {
  std::size_t windows = 0;  ///< that show enough to be measured
  double error_px = 0.0;    ///< the largest of all windows, in texels: shift of the picture and of the coordinates
  Vec2 at;                  ///< middle of that window, site CRS
};

/// Measures a tile of level 0. Windows of 48 x 48 texels, 16 per tile, are registered on the photo by least squares
/// (Lucas and Kanade 1981, sec. 4, with a gain and an offset of brightness), exact for shifts of up to about two
/// texels. Where the scene has lifted shadows (scene/ground/photo_shadows) texels do not count: places that are
/// brighter where hardly any is darker, and then what is over four standard deviations off. Windows that are left with
/// less than half of their texels are not measured. To the worst of them comes the worst difference between a vertex's
/// place and its texture coordinate.
[[nodiscard]] TexturePosition texture_position(const SceneTile& tile, const BrightnessAt& photo);

}  // namespace orthodrive
