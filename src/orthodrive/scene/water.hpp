#pragma once
// Lakes and rivers: each lies at one level.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/rasters.hpp"
#include "orthodrive/scene/outline.hpp"
#include "orthodrive/scene/road_level.hpp"
#include "orthodrive/scene/road_tint.hpp"

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
  const HeightGrid& terrain;
  const Photo& photo;
  const Polygon& area;
  double shore_m = 5.0;  ///< from roads, whose verges end there
};

class Waters {
 public:
  Waters() = default;
  /// The level of a body is the lower quartile of the terrain model in it. Where a tenth of the terrain is more than
  /// 3 m over another tenth there is no level: finding "scene.water_slope", and no water. Bodies lose what is nearer to
  /// a road than the shore, and what they share with those before them.
  Waters(const MultiPolygon& polygons, const WaterInput& input, Findings& findings);

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
