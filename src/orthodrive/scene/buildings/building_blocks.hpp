// SPDX-License-Identifier: Apache-2.0
#pragma once
// Buildings seen from afar: fewer corners, flat roofs, small ones left out.

#include <span>

#include "orthodrive/scene/buildings/buildings.hpp"

namespace orthodrive::scene {

struct BlockOptions {
  double outline_m = 0.5;  ///< footprints lose corners that move their border by less
  double roof_m = 1.0;     ///< roofs become flat, at half their height, where that moves them by less
  double size_m = 0.0;     ///< buildings that are no higher are left out
};

struct Blocks {
  TriMesh mesh;          ///< as building_mesh() makes blocks, without features
  double error_m = 0.0;  ///< the largest distance that a silhouette has moved
};

/// Positions relative to `origin`. What the options do not allow stays as it is.
[[nodiscard]] Blocks building_blocks(std::span<const PlacedBuilding* const> buildings, Vec3 origin,
                                     const BlockOptions& options);

}  // namespace orthodrive::scene
