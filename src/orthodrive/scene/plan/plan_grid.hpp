// SPDX-License-Identifier: Apache-2.0
#pragma once
// The grid of all plan coordinates of the scene.

#include <cmath>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::scene {

/// A power of two: offsets of up to 16 km from a point of the grid are exact in float, so that triangles cannot flip
/// and tile borders cannot open when doubles become floats.
constexpr double plan_grid_m = 1.0 / 1024.0;

[[nodiscard]] inline Vec2 snap_to_grid(Vec2 p) {
  return {std::round(p.x / plan_grid_m) * plan_grid_m, std::round(p.y / plan_grid_m) * plan_grid_m};
}

}  // namespace orthodrive::scene
