// SPDX-License-Identifier: Apache-2.0
#pragma once
// What all blocks of a scene share. Small: its size goes with the border of the area and the number of lakes.

#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/scene/ground/terrain_windows.hpp"
#include "orthodrive/scene/ground/water_levels.hpp"
#include "orthodrive/scene/plan/outline.hpp"
#include "orthodrive/scene/plan/scene_input.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"

namespace orthodrive::scene {

struct SceneFrame {
  /// Throws OptionError without an area or with options out of range, InputError when the terrain has no height.
  SceneFrame(const SceneSource& source, const SceneOptions& options);
  SceneFrame(const SceneFrame&) = delete;

  SceneOptions options;
  PhotoSource photo;               ///< without shadows where there are labels
  Polygon area;                    ///< on the plan grid
  MultiPolygon dense_area;         ///< its rings with points at most a terrain step apart, oriented and clean
  Box2 bounds;                     ///< of the area
  Findings findings;               ///< of terrain and water
  Outline outline;                 ///< of the area
  std::vector<TileAddress> tiles;  ///< those that share ground with the area, by column, then row
  std::unique_ptr<const TerrainWindows> terrain;        ///< never null
  std::vector<std::optional<WaterLevel>> water_levels;  ///< one for each polygon of the surroundings' water
  std::vector<std::vector<double>> power_ground_m;  ///< terrain at the points of each of the surroundings' power lines
  std::set<int> roads_over;                         ///< ids of roads on the ground that lie over others: drawn as decks
  Vec3 origin;                                      ///< middle of the area at a height of the terrain, whole metres
};

}  // namespace orthodrive::scene
