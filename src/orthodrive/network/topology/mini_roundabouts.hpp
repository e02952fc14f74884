// SPDX-License-Identifier: Apache-2.0
#pragma once
// Mini-roundabouts, which OSM has as one node (highway=mini_roundabout).

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::network {

struct MiniRoundaboutDisc {
  Vec2 middle;
  double radius_m = 0.0, lane_m = 0.0;  ///< of the paved disc, and of the middle of the lane
};

/// The node becomes a ring on a paved disc (16 m across where no tag tells), gone round as one drives: then it is a
/// roundabout as any other. Its roads end at the ring; a way that goes on beyond it becomes two paths, the second one
/// last in the list, then the ring, which is a part of the way of the highest class. Near other junctions discs are
/// smaller. Nodes without heights are not allowed (with_heights).
/// `discs` gets one for each that was laid. Findings: network.no_room_for_mini_roundabout (stays a plain junction);
/// network.roundabout_against_traffic (its tag `direction` is not as one drives there, which counts);
/// network.turn_restriction_left_out (at the node).
[[nodiscard]] RoadNetwork lay_mini_roundabouts(RoadNetwork roads, DrivingSide driving_side,
                                               std::vector<MiniRoundaboutDisc>& discs, Findings& findings);

}  // namespace orthodrive::network
