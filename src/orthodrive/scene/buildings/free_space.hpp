// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where nothing stands: beside roads, decks, openings of the ground and buildings with their roofs, in the area.

#include <limits>
#include <span>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/buildings/buildings.hpp"
#include "orthodrive/scene/roads/road_level.hpp"

namespace orthodrive::scene {

/// Outlines of roads must reach as far as is asked for. All is borrowed.
struct Obstacles {
  std::span<const RoadLevel* const> levels;
  std::span<const PlacedBuilding> buildings;
  const Outline& area;
  const Outline& openings;
};

/// What does not count.
struct FreeOf {
  double below_z_m = std::numeric_limits<double>::infinity();     ///< roads that lie higher where they are nearest
  std::size_t besides = std::numeric_limits<std::size_t>::max();  ///< the building of that number
};

class FreeSpace {
 public:
  explicit FreeSpace(const Obstacles& obstacles);
  /// The radius of the free disc around p, up to the one given; 0 outside the area and on what stands there.
  [[nodiscard]] double around(Vec2 p, double radius_m, const FreeOf& but = {}) const;
  [[nodiscard]] bool is_in_area(Vec2 p) const { return obstacles_.area.contains(p); }

 private:
  Obstacles obstacles_;
  SpatialIndex index_;
};

}  // namespace orthodrive::scene
