// SPDX-License-Identifier: Apache-2.0
#pragma once
// Dual carriageways of maps that lost the tag `oneway`.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::network {

/// Whether a way besides roundabouts is one-way: then the tags of the others are to be believed.
[[nodiscard]] bool has_oneway_tags(const RoadNetwork& roads);

/// For maps without such tags. Two-way roads of one class (tertiary and higher) and name that run side by side, 3 to
/// 30 m apart, are the carriageways of one road: each becomes one-way, with the other one on the side of the oncoming
/// traffic (finding network.carriageway_assumed). At least 60 % of a way has to have such a neighbour on that side, at
/// most 20 % on the other side; ways that go on from it without a junction follow it. Ways that run on into each other,
/// as before and behind a hairpin, are no neighbours. What one could then no longer enter or leave stays two-way.
[[nodiscard]] RoadNetwork assume_carriageways(RoadNetwork roads, DrivingSide driving_side, Findings& findings);

}  // namespace orthodrive::network
