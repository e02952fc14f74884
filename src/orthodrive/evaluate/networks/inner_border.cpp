// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/inner_border.hpp"

#include <cstdlib>

namespace orthodrive::evaluate {

roadquery::SurfacePoint inner_border(const roadquery::RoadEnd& end, int lane_id) {
  const roadquery::LaneSection& section = end.section();
  double t = roadquery::evaluate(end.road->lane_offset, end.s());
  for (const roadquery::Lane& lane : lane_id > 0 ? section.left : section.right)
    if (std::abs(lane.id) < std::abs(lane_id))
      t += (lane_id > 0 ? 1.0 : -1.0) * roadquery::lane_width(lane, end.s() - section.s);
  return roadquery::surface_point(*end.road, end.s(), t);
}

}  // namespace orthodrive::evaluate
