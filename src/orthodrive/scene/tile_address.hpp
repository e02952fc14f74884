// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tiles of level 0 and blocks of them, by place.

#include <cmath>

#include "orthodrive/scene/build_scene.hpp"

namespace orthodrive::scene {

[[nodiscard]] inline Box2 tile_box(TileAddress a) {
  return {a.column * scene_tile_m, a.row * scene_tile_m, (a.column + 1) * scene_tile_m, (a.row + 1) * scene_tile_m};
}

[[nodiscard]] inline TileAddress tile_at(Vec2 p) {
  return {static_cast<int>(std::floor(p.x / scene_tile_m)), static_cast<int>(std::floor(p.y / scene_tile_m))};
}

}  // namespace orthodrive::scene
