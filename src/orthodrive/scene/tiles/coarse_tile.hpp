// SPDX-License-Identifier: Apache-2.0
#pragma once
// Coarser levels of detail: one tile out of the up to four of the level below.

#include <span>

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/buildings.hpp"

namespace orthodrive::scene {

/// What is left of a finished tile for the levels above: without paint, verges, buildings, features and tileable
/// materials of roads.
[[nodiscard]] SceneTile ready_to_coarsen(SceneTile tile);

/// Whether a building is drawn on a level above 0.
[[nodiscard]] bool is_seen_on(const PlacedBuilding& building, int level);

/// Joins tiles of one level that have one parent. Half of the photo's resolution; roads show the photo; terrain, roads,
/// bridges and the like lose what 0.25 m * 2^level allows; buildings are blocks (scene/buildings/building_blocks.hpp);
/// trees are lumps, from level 2 on one for all of a square of 2 m * 2^level, from level 4 on none.
/// SceneTile::geometric_error_m is the largest of: that of the tiles below plus the measured change in height; what
/// blocks have moved; half a square of trees, the tallest tree left out; a texel of the photo. `buildings`: those in
/// the tile that were seen on the level below.
[[nodiscard]] SceneTile coarse_tile(std::span<const SceneTile* const> tiles,
                                    std::span<const PlacedBuilding* const> buildings = {});

}  // namespace orthodrive::scene
