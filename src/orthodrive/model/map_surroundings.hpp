// SPDX-License-Identifier: Apache-2.0
#pragma once
// What maps know beside roads, buildings and trees.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "roadquery/map/surface_class.hpp"

namespace orthodrive {

enum class BarrierKind : std::uint8_t { hedge, wall, fence, guard_rail };

struct MapBarrier {
  BarrierKind kind = BarrierKind::wall;
  Polyline line;          ///< site CRS, as all here
  double height_m = 0.0;  ///< 0: not known
};

/// What stands at a point. Those of traffic often lie on the road's axis in maps.
enum class ObjectKind : std::uint8_t {
  traffic_signals,
  stop_sign,
  give_way_sign,
  speed_sign,
  warning_sign,
  city_sign,
  other_sign,
  bus_stop,
  bus_shelter,
  power_tower,
  power_pole,
  bench,
  waste_basket,
  post_box,
  telephone,
  recycling,
  bollard,
  gate,
  lift_gate,
  fire_hydrant,
  tower,
  mast,
  chimney,
  storage_tank,
};

struct MapObject {
  ObjectKind kind = ObjectKind::other_sign;
  Vec2 at;
  double height_m = 0.0;  ///< 0: not known
  double radius_m = 0.0;  ///< of towers, chimneys and tanks; 0: not known
};

struct MapPowerLine {
  Polyline line;          ///< a tower or pole at each point
  bool is_minor = false;  ///< on poles
};

/// For people on foot or bicycles, on the ground.
struct MapPath {
  Polyline line;
  double width_m = 0.0;
  roadquery::SurfaceClass surface = roadquery::SurfaceClass::asphalt;
};

struct MapSurroundings {
  std::vector<MapBarrier> barriers;
  MultiPolygon water;
  MultiPolygon gravel;   ///< ground of gravel or sand: traps of race tracks and the like
  MultiPolygon parking;  ///< car parks on the ground
  std::vector<MapPath> paths;
  std::vector<Polyline> tracks;  ///< of railways on the ground: the middle of a pair of rails
  std::vector<Vec2> lamps;       ///< of streets
  std::vector<MapObject> objects;
  std::vector<MapPowerLine> power_lines;
};

}  // namespace orthodrive
