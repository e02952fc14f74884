// SPDX-License-Identifier: Apache-2.0
#pragma once
// A picture of the ground for roads alone, where no photo is given.

#include <span>

#include "orthodrive/model/building.hpp"
#include "orthodrive/model/map_surroundings.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::scene {

/// What is drawn. Borrowed: only while the picture is made.
struct DrawnMap {
  const roadquery::RoadMap& roads;
  std::span<const Building> buildings = {};
  const MapSurroundings* surroundings = nullptr;
};

/// Grass, whose colour changes slowly from place to place, and on it in plain colours what the map has: water, gravel,
/// car parks, roofs of buildings, junctions, and the lanes of roads by what they are made of. Roads in tunnels are not
/// seen. Pixels of 0.5 m; a pixel is the same in every window.
[[nodiscard]] PhotoSource generic_ground(const DrawnMap& map, const Crs& crs, const Box2& box);

}  // namespace orthodrive::scene
