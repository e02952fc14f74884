// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a lake or a river is over all of its length, however little of it a window shows.

#include <optional>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/scene/ground/terrain_windows.hpp"
#include "orthodrive/scene/plan/outline.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"

namespace orthodrive::scene {

struct WaterLevel {
  double level_m = 0.0;
  LinearColor color{};
};

/// One for each polygon; nothing for those that are not drawn. The level is the lower quartile of the terrain model in
/// it, the colour the photo's median between dark and bright water, both at places of a raster of 3 m or as much more
/// as makes 20,000 of them, in the area. Where a tenth of the terrain is more than 3 m over another tenth there is no
/// level: finding "scene.water_slope".
[[nodiscard]] std::vector<std::optional<WaterLevel>> water_levels(const MultiPolygon& polygons, const Outline& area,
                                                                  const TerrainWindows& terrain,
                                                                  const PhotoSource& photo, Findings& findings);

}  // namespace orthodrive::scene
