// SPDX-License-Identifier: Apache-2.0
#pragma once
// What lies between the roads of large plans: areas, woods and lakes, farms.

#include "orthodrive/core/random.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// With an id of its own.
void add_area(SitePlan& plan, Ring ring, Cover cover, bool mapped);

/// A house and a barn behind a yard. `outward`: unit vector from the road.
void add_farm(SitePlan& plan, Vec2 yard, Vec2 outward, Random& random);

/// At random places of the site: up to `count` lakes where no road is within 30 m, up to four times as many woods, off
/// settlements and lakes. None of them in `kept_free`.
void add_lakes_and_woods(SitePlan& plan, int count, const MultiPolygon& kept_free, Random& random);

}  // namespace orthodrive::synth
