// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lines along roads in the colours and with the strokes of a country.

#include "orthodrive/model/roads/road_mark_rules.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Gives the lane marks of all roads the colours of the rule, and writes out the strokes of broken lines where it has
/// them, by the limit of the road. Where both sides have driven lanes, the line of the centre lane lies between
/// opposite directions, and so does that of a lane for both. That of the centre lane of a one-way road is its inner
/// edge, but for race tracks.
void follow_mark_rule(const RoadMarkRule& rule, roadquery::RoadMap& map);

}  // namespace orthodrive::network
