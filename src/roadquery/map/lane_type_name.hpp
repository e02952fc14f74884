// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// As e_laneType of OpenDRIVE has it; "other" for what we do not tell apart.
[[nodiscard]] constexpr const char* lane_type_name(LaneType type) {
  switch (type) {
    case LaneType::none:
      return "none";
    case LaneType::driving:
      return "driving";
    case LaneType::shoulder:
      return "shoulder";
    case LaneType::border:
      return "border";
    case LaneType::sidewalk:
      return "sidewalk";
    case LaneType::parking:
      return "parking";
    case LaneType::biking:
      return "biking";
    case LaneType::bidirectional:
      return "bidirectional";
    case LaneType::bus:
      return "bus";
    case LaneType::taxi:
      return "taxi";
    case LaneType::other:
      break;
  }
  return "other";
}

}  // namespace roadquery
