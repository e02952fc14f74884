// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/single_sides.hpp"

#include <algorithm>

#include "roadquery/roads/later_start.hpp"

namespace roadquery {
namespace {

/// What a lane is linked to behind its end lies behind the end of its last part.
void continue_lanes(std::vector<Lane>& before, std::vector<Lane>& lanes, double by_m) {
  lanes = before;
  for (Lane& lane : lanes) {
    start_lane_later(lane, by_m);
    lane.predecessor = lane.id;
  }
  for (Lane& lane : before) lane.successor = lane.id;
}

}  // namespace

void continue_sides(Road& road, const std::vector<RoadParts::SingleSide>& single_sides) {
  if (single_sides.empty()) return;
  for (std::size_t i = 1; i < road.sections.size(); ++i) {
    LaneSection &before = road.sections[i - 1], &section = road.sections[i];
    const auto single = std::find_if(single_sides.begin(), single_sides.end(),
                                     [&](const RoadParts::SingleSide& side) { return side.s == section.s; });
    if (single == single_sides.end()) continue;
    const double by_m = section.s - before.s;
    if (!single->has_left && section.left.empty()) continue_lanes(before.left, section.left, by_m);
    if (!single->has_right && section.right.empty()) continue_lanes(before.right, section.right, by_m);
  }
}

}  // namespace roadquery
