// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which roads belong to a junction's paved area, and which junctions share ground.

#include <vector>

#include "orthodrive/network/junctions/junction_area.hpp"

namespace orthodrive::network {

/// The junction's roads by index of the map.
struct JunctionMembers {
  std::vector<std::size_t> connecting;
  std::vector<std::size_t> arms;    ///< roads that end at the junction
  std::vector<bool> at_end;         ///< of each arm: its end (else its start) touches the junction
  std::vector<std::size_t> inner;   ///< roads to the next junction so short that both junctions cover them
  std::vector<std::size_t> others;  ///< near and on the level of the junction, neither of these
};

/// Of every junction of the map, in its order.
[[nodiscard]] std::vector<JunctionMembers> junction_members(const roadquery::RoadMap& map, int threads);

[[nodiscard]] JunctionRoads roads_of(const roadquery::RoadMap& map, const JunctionMembers& members);

/// The paved area of a junction.
struct JunctionGround {
  Ring boundary;  ///< one ring for all parts (woven_ring), relative to `origin`; empty without an area
  Vec2 origin;
  double area_m2 = 0.0;
};

/// Groups of junctions whose areas overlap on one level, or that have a road in common that both cover: their heights
/// must be one field. Indices ascend in each group, groups by their first; junctions without an area are in none.
[[nodiscard]] std::vector<std::vector<std::size_t>> junctions_on_one_ground(const roadquery::RoadMap& map,
                                                                            const std::vector<JunctionMembers>& members,
                                                                            const std::vector<JunctionGround>& grounds);

}  // namespace orthodrive::network
