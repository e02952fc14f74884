// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a scene is made of, and how.

#include <optional>
#include <span>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/model/building.hpp"
#include "orthodrive/model/map_surroundings.hpp"
#include "orthodrive/model/rasters/raster_source.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// Borrowed: what is given must outlive the call, for lay_out_scene() the layout. All in the site CRS.
struct SceneInput {
  const roadquery::RoadMap& roads;
  const HeightGrid& terrain;  ///< bare earth; holes are filled from their surroundings and found
  const Photo& photo;
  Polygon area;                                   ///< the scene ends here
  const LabelMap* labels = nullptr;               ///< if given, tiles carry the classes, for simulators and viewers
  std::span<const Building> buildings = {};       ///< of maps; labels show what they lack
  std::span<const Vec2> trees = {};               ///< single trees of maps; labels show the others
  const MapSurroundings* surroundings = nullptr;  ///< barriers, water, railways, lamps, objects of maps
};

/// The same with rasters that are read window by window, from several threads at once.
struct SceneSource {
  const roadquery::RoadMap& roads;
  HeightSource terrain;
  PhotoSource photo;
  Polygon area;
  std::optional<LabelSource> labels;
  std::span<const Building> buildings = {};
  std::span<const Vec2> trees = {};
  const MapSurroundings* surroundings = nullptr;
};
/// The input must outlive the source.
[[nodiscard]] SceneSource source_of(const SceneInput& input);

struct SceneOptions {
  double road_tolerance_m = 0.02;  ///< of the road mesh's edges from the exact ones
  double terrain_step_m = 10.0;    ///< distance of terrain vertices, also along tile borders
  double verge_m = 5.0;            ///< over this distance from a road the ground goes from the road's edge to the DTM
  double deck_thickness_m = 0.8;   ///< of bridges
  int block_tiles = 4;  ///< a side of what is laid out at a time, a power of two; the result does not depend on it
  int max_texture_px = 2048;  ///< a tile side; photos coarser than that keep their own resolution
  int threads = 0;            ///< 0 = all cores; the result does not depend on it
};

}  // namespace orthodrive
