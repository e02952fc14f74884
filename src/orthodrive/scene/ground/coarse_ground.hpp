// SPDX-License-Identifier: Apache-2.0
#pragma once
// Terrain and roads of a coarser level of detail.

#include <span>

#include "orthodrive/model/scene.hpp"

namespace orthodrive::scene {

struct CoarseGround {
  TriMesh terrain, road;  ///< relative to the new origin; they share the vertices where they meet
  double error_m = 0.0;   ///< largest difference in height at a vertex of the finer tiles
};

struct CoarseGroundOptions {
  Vec3 origin;               ///< of the new tile
  double side_m = 960.0;     ///< of the new tile
  double tolerance_m = 0.5;  ///< that the simplification aims at
};

/// Joins the grounds of the tiles and takes away what the tolerance allows: edges collapse by quadric errors (Garland
/// and Heckbert, Surface simplification using quadric error metrics, 1997; meshoptimizer). Vertices on the new tile's
/// border, on the area's and on those of decks stay, all of them, so that tiles of any levels meet without a crack.
[[nodiscard]] CoarseGround coarse_ground(std::span<const SceneTile* const> tiles, const CoarseGroundOptions& options);

}  // namespace orthodrive::scene
