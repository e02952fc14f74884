// SPDX-License-Identifier: Apache-2.0
#pragma once
// What lies on roads or stands across them: humps and barriers, as objects.

#include <span>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/network/line/network_plan.hpp"
#include "orthodrive/network/line/raise_humps.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// A box over the carriageway for every hump (traffic_calming.hpp). The height is the road's; the object says that it
/// is meant, and of what kind.
void add_hump_objects(std::span<const RaisedHump> humps, roadquery::RoadMap& map);

/// Barriers that OSM has on nodes of roads, as objects across their road (road_barriers.hpp); inside a junction across
/// the connecting road that follows the way best; up to 6 m along the way where its road ends before. Findings:
/// network.barrier_in_the_way (cars may not pass), network.barrier_left_out (no road runs under it).
void add_barriers(const NetworkPlan& plan, roadquery::RoadMap& map, Findings& findings);

}  // namespace orthodrive::network
