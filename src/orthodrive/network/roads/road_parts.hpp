// SPDX-License-Identifier: Apache-2.0
#pragma once
// The roads themselves: pieces of chains between the cuts, and the roads that connect them through junctions.

#include <map>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/network/line/network_plan.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Roads of all stretches, linked where they follow each other without a junction, ids from 1. Returns the ends at
/// every junction, in the order of the stretches. Finding network.too_many_lanes: more were tagged than the width has
/// room for.
[[nodiscard]] std::vector<std::vector<JunctionEnd>> add_roads(const NetworkPlan& plan, roadquery::RoadMap& map,
                                                              Findings& findings);

struct JunctionParts {
  std::vector<int> straight;  ///< ids of the connecting roads that go straight on, cut from their chain, ascending
  std::map<int, double> kerb_radius_m;  ///< of the junctions of which it was seen: the median of their nodes'
};

/// Connecting roads and junctions. From every incoming lane group to every other road of the junction that can be
/// reached: no U-turns, one-way roads in their direction. Junctions without any connection are left out. Finding
/// network.turn_left_out: turns of 140 to 150 degrees into a road that leads back to the same other junction.
/// network.no_room_to_turn: lanes that would turn round into one on their other side.
JunctionParts add_junctions(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends,
                            roadquery::RoadMap& map, Findings& findings);

}  // namespace orthodrive::network
