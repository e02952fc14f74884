// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tiles of level 0 and blocks of them, by place.

#include <cmath>
#include <compare>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive {

/// Tiles of level 0 are squares of 480 m whose corners are multiples of 480 m in the site CRS.
constexpr double scene_tile_m = 480.0;

struct TileAddress {
  int column = 0, row = 0;  ///< easting / 480 m, northing / 480 m, rounded down
  friend auto operator<=>(const TileAddress&, const TileAddress&) = default;
};

namespace scene {

/// The tile of the next level that covers an address.
[[nodiscard]] inline TileAddress parent_of(TileAddress a) { return {a.column >> 1, a.row >> 1}; }

[[nodiscard]] inline Box2 tile_box(TileAddress a) {
  return {a.column * scene_tile_m, a.row * scene_tile_m, (a.column + 1) * scene_tile_m, (a.row + 1) * scene_tile_m};
}

[[nodiscard]] inline TileAddress tile_at(Vec2 p) {
  return {static_cast<int>(std::floor(p.x / scene_tile_m)), static_cast<int>(std::floor(p.y / scene_tile_m))};
}

}  // namespace scene

}  // namespace orthodrive
