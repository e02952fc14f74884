// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small exact road maps to drive on.

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "roadquery/make_road.hpp"

namespace orthodrive::test {

using roadquery::Arc;
using roadquery::ContactPoint;
using roadquery::Line;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadLink;
using roadquery::RoadMap;
using roadquery::test::append;
using roadquery::test::make_road;

inline RoadMap map_of(std::vector<Road> roads) {
  RoadMap map;
  map.roads = std::move(roads);
  return map;
}

/// a's end leads into b's start.
inline void link(Road& a, Road& b) {
  a.successor = {LinkKind::road, b.id, ContactPoint::start};
  b.predecessor = {LinkKind::road, a.id, ContactPoint::end};
}

/// A circle of that radius about (0, 0), counter-clockwise, linked to itself; the right lane is the outer one.
inline Road make_circle(int id, double radius_m, double z_m = 0.0) {
  Road road = make_road(
      id, {0.0, radius_m, 0.0, 0.5 * std::numbers::pi, 2.0 * std::numbers::pi * radius_m, Arc{1.0 / radius_m}}, z_m);
  link(road, road);
  return road;
}

/// A stadium: two straights of `straight_m`, two half circles; four linked roads with ids from `id`. Starts at (x, y)
/// going east, turns left.
inline std::vector<Road> make_stadium(int id, double x, double y, double straight_m, double radius_m) {
  const double half_m = std::numbers::pi * radius_m, pi = std::numbers::pi;
  std::vector<Road> roads = {make_road(id, {0.0, x, y, 0.0, straight_m, Line{}}),
                             make_road(id + 1, {0.0, x + straight_m, y, 0.0, half_m, Arc{1.0 / radius_m}}),
                             make_road(id + 2, {0.0, x + straight_m, y + 2.0 * radius_m, pi, straight_m, Line{}}),
                             make_road(id + 3, {0.0, x, y + 2.0 * radius_m, pi, half_m, Arc{1.0 / radius_m}})};
  for (std::size_t i = 0; i < 4; ++i) link(roads[i], roads[(i + 1) % 4]);
  return roads;
}

}  // namespace orthodrive::test
