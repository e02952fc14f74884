// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roundabouts that the map draws incompletely or not at all. Their rings are found in rings.hpp.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::network {

/// Ways tagged as roundabouts whose end does not meet their beginning are closed along their circle where less than a
/// third of it is missing (finding network.roundabout_closed); others stay open one-way roads
/// (network.roundabout_open). Rings that the border of the area cuts are left as they are.
[[nodiscard]] RoadNetwork close_roundabouts(RoadNetwork roads, Findings& findings);

/// Rings tagged as roundabouts that are drawn against the traffic, clockwise where one drives on the right: finding
/// network.roundabout_against_traffic for each. They are built as drawn.
void report_turned_roundabouts(const RoadNetwork& roads, DrivingSide driving_side, Findings& findings);

/// Circles of two-way roads that nothing says to be roundabouts: maps that lost their tags have them. Nobody builds a
/// small round of road with arms to be driven both ways, so it becomes a one-way road round the island, in the sense of
/// the traffic (finding network.roundabout_assumed). The ways of the ring have to be all ring: 30 to 200 m round, as
/// round as a circle, with three or more arms, none of them inside, no service roads.
[[nodiscard]] RoadNetwork assume_roundabouts(RoadNetwork roads, DrivingSide driving_side, Findings& findings);

}  // namespace orthodrive::network
