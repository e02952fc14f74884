// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sidewalks of a map and the joints between them.

#include <map>
#include <utility>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// A sidewalk of a road outside junctions. The road has one lane section.
struct SidewalkLane {
  std::size_t road = 0;
  bool left = false;

  [[nodiscard]] roadquery::Lane* lane(roadquery::RoadMap& map) const;  ///< null: there is none on that side
  /// t of the inner border.
  [[nodiscard]] double inner_t(const roadquery::Road& of, double s) const;
};

[[nodiscard]] std::vector<SidewalkLane> sidewalk_lanes(roadquery::RoadMap& map);

/// One end of a sidewalk and that of the one that it goes on into.
struct SidewalkJoint {
  std::size_t walk = 0, next = 0;  ///< indices of sidewalk_lanes(); next = walks: the other road has none there
  bool at_end = false, next_at_end = false;  ///< of the roads
};
/// At every end of a sidewalk where its road is linked to another road.
[[nodiscard]] std::vector<SidewalkJoint> sidewalk_joints(const roadquery::RoadMap& map,
                                                         const std::vector<SidewalkLane>& walks);

}  // namespace orthodrive::network
