#pragma once
// What maps know beside roads, buildings and trees.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {

enum class BarrierKind : std::uint8_t { hedge, wall, fence, guard_rail };

struct MapBarrier {
  BarrierKind kind = BarrierKind::wall;
  Polyline line;          ///< site CRS, as all here
  double height_m = 0.0;  ///< 0: not known
};

struct MapSurroundings {
  std::vector<MapBarrier> barriers;
  MultiPolygon water;
  std::vector<Polyline> tracks;  ///< of railways on the ground: the middle of a pair of rails
  std::vector<Vec2> lamps;       ///< of streets
};

}  // namespace orthodrive
