// SPDX-License-Identifier: Apache-2.0
#pragma once
// What stands across roads: OSM's barrier on nodes of roads (https://wiki.openstreetmap.org/wiki/Key:barrier).

#include <string_view>

namespace orthodrive {

struct RoadBarrier {
  std::string_view value;          ///< OSM's; empty: any other one
  const char* object = "barrier";  ///< <object> type of OpenDRIVE: "obstacle" for what cannot be passed
  double length_m = 0.1;           ///< along the road
  double width_m = 0.0;            ///< across it, in its middle; 0: the whole carriageway
  double height_m = 1.0;           ///< 0: flush with the road
  bool closes = false;             ///< cars do not pass where no tag of access tells
};

/// Of a value; for others that of a thing of 1 m across the road that cars pass.
[[nodiscard]] const RoadBarrier& road_barrier(std::string_view value);

}  // namespace orthodrive
