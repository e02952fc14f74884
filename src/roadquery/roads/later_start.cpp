// SPDX-License-Identifier: Apache-2.0
#include "roadquery/roads/later_start.hpp"

namespace roadquery {

void start_lane_later(Lane& lane, double by_m) {
  move_back(lane.width, by_m, place_s);
  move_back(lane.marks, by_m, place_offset);
  move_back(lane.materials, by_m, place_offset);
  move_back(lane.speeds, by_m, place_s);
  for (LaneHeight& height : lane.heights) height.s_offset -= by_m;
  for (RoadMark& mark : lane.marks) mark.s_offset = std::max(mark.s_offset, 0.0);
  for (LaneMaterial& material : lane.materials) material.s_offset = std::max(material.s_offset, 0.0);
  for (SpeedLimit& limit : lane.speeds) limit.s = std::max(limit.s, 0.0);
}

}  // namespace roadquery
