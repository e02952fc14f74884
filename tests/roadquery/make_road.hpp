// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small exact roads for tests.

#include <cmath>
#include <numbers>
#include <utility>

#include "roadquery/surface/road_surface.hpp"

namespace roadquery::test {

inline Lane make_lane(int id, double width_m) {
  Lane lane;
  lane.id = id;
  lane.type = LaneType::driving;
  lane.width = {{.s = 0.0, .a = width_m}};
  return lane;
}

/// A road of one element with one driving lane of `lane_width_m` to each side, flat at height z.
inline Road make_road(int id, PlanElement element, double z_m = 0.0, double lane_width_m = 3.5) {
  Road road;
  road.id = id;
  road.length = element.length;
  road.plan = {std::move(element)};
  road.elevation = {{.s = 0.0, .a = z_m}};
  LaneSection section;
  section.left = {make_lane(1, lane_width_m)};
  section.right = {make_lane(-1, lane_width_m)};
  road.sections = {section};
  return road;
}

/// Adds an element that continues the last one without a gap or kink.
inline void append(Road& road, double length_m, PlanShape shape) {
  const PlanElement& last = road.plan.back();
  const PlanPoint end = evaluate(last, last.length);
  road.plan.push_back({last.s + last.length, end.x, end.y, end.hdg, length_m, shape});
  road.length += length_m;
}

}  // namespace roadquery::test
