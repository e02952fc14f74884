// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/lane_arrows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Road;

constexpr double gap_m = 4.0, repeat_m = 25.0;
constexpr double arrow_m = 5.0, fast_arrow_m = 7.5, fast_mps = 70.0 / 3.6, arrow_width_m = 1.2;
constexpr double min_arrow_lane_m = 2.0;

/// Nullptr for lanes that show nothing, or that end.
const char* subtype_of(unsigned bits) {
  switch (bits) {
    case turn_left:
      return "arrowLeft";
    case turn_through:
      return "arrowStraight";
    case turn_right:
      return "arrowRight";
    case turn_left | turn_through:
      return "arrowStraightLeft";
    case turn_through | turn_right:
      return "arrowStraightRight";
    case turn_left | turn_right:
      return "arrowLeftRight";
    case turn_left | turn_through | turn_right:
      return "arrowStraightLeftRight";
    default:
      return nullptr;
  }
}

/// How far before the road's end the waiting line or the crosswalk reaches.
double taken_m(const Road& road, bool at_end) {
  constexpr double near_m = 20.0;
  double taken = 0.0;
  for (const roadquery::RoadObject& object : road.objects) {
    const double far_m = (at_end ? road.length - object.s : object.s) + 0.5 * object.length;
    if (far_m < near_m) taken = std::max(taken, far_m);
  }
  return taken;
}

void add_arrows(Road& road, bool at_end, const std::vector<unsigned>& shown) {
  const std::vector<int> ids = lanes_of_direction(road, at_end);
  if (ids.size() != shown.size()) return;
  const double length_m = road.speed_limit_mps >= fast_mps ? fast_arrow_m : arrow_m;
  const double first_m = taken_m(road, at_end) + gap_m + 0.5 * length_m;
  const double hdg = at_end ? 0.0 : std::numbers::pi;
  for (const double before_m : {first_m, first_m + repeat_m}) {
    if (before_m + 0.5 * length_m + gap_m > road.length) return;
    const double s = at_end ? road.length - before_m : before_m;
    const roadquery::LaneSection& section = roadquery::section_at(road, s);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const bool left = ids[i] > 0;
      double t = roadquery::evaluate(road.lane_offset, s), width = 0.0;
      for (const roadquery::Lane& lane : left ? section.left : section.right) {
        t += (left ? 0.5 : -0.5) * width;
        width = roadquery::lane_width(lane, s - section.s);
        t += (left ? 0.5 : -0.5) * width;
        if (lane.id == ids[i]) break;
      }
      const char* subtype = subtype_of(shown[i]);
      if (subtype == nullptr || width < min_arrow_lane_m) continue;
      road.objects.push_back({.type = "roadMark",
                              .subtype = subtype,
                              .s = s,
                              .t = t,
                              .hdg = hdg,
                              .length = length_m,
                              .width = arrow_width_m});
    }
  }
}

}  // namespace

void add_lane_arrows(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends,
                     roadquery::RoadMap& map) {
  for (const std::vector<JunctionEnd>& junction : ends) {
    for (const JunctionEnd& end : junction) {
      Road& road = map.roads[static_cast<std::size_t>(end.road)];
      const std::vector<unsigned> shown = turn_lanes(plan.roads.paths[end.path], end.at_end, plan.options.driving_side);
      if (!shown.empty()) add_arrows(road, end.at_end, shown);
    }
  }
}

}  // namespace orthodrive::network
