// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lakes and rivers: each lies at one level.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/ground/water_levels.hpp"
#include "orthodrive/scene/plan/outline.hpp"
#include "orthodrive/scene/roads/road_level.hpp"

namespace orthodrive::scene {

struct WaterBody {
  MultiPolygon shores;  ///< beside roads and other water, in the area; on the plan grid
  Box2 box;
  Outline outline;  ///< of the shores
  double level_m = 0.0;
  LinearColor color{};
};

struct WaterInput {
  const RoadLevel& roads;  ///< on the ground
  const Polygon& area;
  Box2 box;              ///< shores are needed there
  double shore_m = 5.0;  ///< from roads, whose verges end there
};

class Waters {
 public:
  Waters() = default;
  /// Those of the polygons that have a level. Bodies lose what is nearer to a road than the shore, and what they share
  /// with those before them.
  Waters(const MultiPolygon& polygons, std::span<const std::optional<WaterLevel>> levels, const WaterInput& input);

  /// The body that p lies in or, within two steps of the plan grid, on the shore of; nullptr: none.
  [[nodiscard]] const WaterBody* at(Vec2 p) const;
  /// Distance to the nearest shore, up to 2 m.
  [[nodiscard]] double shore_distance_m(Vec2 p) const;
  [[nodiscard]] const std::vector<WaterBody>& bodies() const { return bodies_; }

 private:
  std::vector<WaterBody> bodies_;
  SpatialIndex index_;
};

}  // namespace orthodrive::scene
