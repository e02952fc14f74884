#pragma once

#include "roadquery/road_map.hpp"

namespace orthodrive::io {

/// As e_laneType of OpenDRIVE has it; "other" for what we do not tell apart.
[[nodiscard]] constexpr const char* lane_type_name(roadquery::LaneType type) {
  switch (type) {
    case roadquery::LaneType::none:
      return "none";
    case roadquery::LaneType::driving:
      return "driving";
    case roadquery::LaneType::shoulder:
      return "shoulder";
    case roadquery::LaneType::border:
      return "border";
    case roadquery::LaneType::sidewalk:
      return "sidewalk";
    case roadquery::LaneType::parking:
      return "parking";
    case roadquery::LaneType::biking:
      return "biking";
    case roadquery::LaneType::other:
      break;
  }
  return "other";
}

}  // namespace orthodrive::io
