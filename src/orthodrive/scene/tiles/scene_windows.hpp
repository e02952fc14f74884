// SPDX-License-Identifier: Apache-2.0
#pragma once
// The part of a scene's sources that a block of tiles needs.

#include <optional>
#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/scene/tiles/scene_frame.hpp"

namespace orthodrive::scene {

/// What lies in a box or reaches into it: rasters as far as the box, roads and all else whole.
struct SceneWindow {
  Box2 box;
  roadquery::RoadMap roads;  ///< with all roads of the junctions there
  HeightGrid terrain;        ///< without holes
  Photo photo;
  std::optional<LabelMap> labels;
  std::vector<Building> buildings;
  std::vector<Vec2> trees;
  std::optional<MapSurroundings> surroundings;
  std::vector<std::optional<WaterLevel>> water_levels;  ///< of the surroundings' water
  std::vector<std::vector<double>> power_ground_m;      ///< terrain at the points of the surroundings' power lines
};

class SceneWindows {
 public:
  /// The source and the frame must outlive it.
  SceneWindows(const SceneSource& source, const SceneFrame& frame);
  /// Safe from any thread.
  [[nodiscard]] SceneWindow window(const Box2& box) const;

 private:
  [[nodiscard]] roadquery::RoadMap roads_in(const Box2& box) const;

  const SceneSource* source_;
  const SceneFrame* frame_;
  SpatialIndex roads_, junctions_;  ///< by their boxes
};

}  // namespace orthodrive::scene
