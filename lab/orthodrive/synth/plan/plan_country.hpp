// SPDX-License-Identifier: Apache-2.0
#pragma once
// The country round a race track: roads, villages, farms, woods and lakes.

#include <cstdint>

#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// Least distance from the track's convex hull to the site's border, m.
constexpr double country_reach_m = 500.0;

/// Adds to a plan of which road 0 is the track, which lies country_reach_m or more within the site: a road round it,
/// another one far out where there is room, roads from the inner one to the site's border, villages on every second of
/// them, farm lanes between them, car parks, farms, woods and lakes. None comes within 60 m of the track's hull. Sets
/// the surroundings of a region.
void add_country(SitePlan& plan, std::uint64_t seed);

}  // namespace orthodrive::synth
