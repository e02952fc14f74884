// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roofs that stand out over walls.

#include <array>
#include <span>
#include <vector>

#include "orthodrive/scene/buildings/roof.hpp"

namespace orthodrive::scene {

struct Eaves {
  std::vector<std::array<Vec3, 3>> slopes;   ///< of the roof, reaching over the walls
  std::vector<std::array<Vec3, 3>> soffits;  ///< look down, between the walls and the border of the slopes
};

/// The roof's slopes go on beyond the outer edge i of the footprint by out_m[i] (plan), in their own planes. Nothing
/// changes where an edge would turn round, a slope fold over or an edge without eaves begin at an inner corner: then
/// `soffits` are empty.
[[nodiscard]] Eaves with_eaves(const Roof& roof, const Ring& outer, std::span<const double> out_m);

}  // namespace orthodrive::scene
