// SPDX-License-Identifier: Apache-2.0
#pragma once
// Height of the ground: roads where they are, the terrain model elsewhere, and what lies between the two.

#include <span>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/scene/ground/water.hpp"
#include "orthodrive/scene/roads/road_level.hpp"

namespace orthodrive::scene {

struct GroundOptions {
  double verge_m = 5.0;  ///< over this distance from a road the ground goes from the road's edge to the terrain
  double deck_clearance_m = 1.1;  ///< the terrain stays this far below bridge decks, less near their abutments
};

class Ground {
 public:
  /// `roads`, `decks` and `waters` must outlive it. The terrain must have a height somewhere.
  Ground(HeightGrid filled_terrain, const RoadLevel& roads, std::span<const RoadLevel> decks, const Waters& waters,
         const GroundOptions& options);

  /// The terrain model, bilinear; beyond its border the border value goes on.
  [[nodiscard]] double terrain_m(Vec2 p) const;
  /// Height of the ground mesh at p, of the water where there is some: continuous but for crossing road borders and
  /// shores. The same for every tile.
  [[nodiscard]] double height_m(Vec2 p) const;
  /// Unit normal by central differences of height_m over 1 m.
  [[nodiscard]] Vec3 normal(Vec2 p) const;

 private:
  HeightGrid terrain_;
  const RoadLevel* roads_;
  std::span<const RoadLevel> decks_;
  const Waters* waters_;
  GroundOptions options_;
};

}  // namespace orthodrive::scene
