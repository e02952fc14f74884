// SPDX-License-Identifier: Apache-2.0
#pragma once
// What lies beside a motor-racing circuit, made or real: verges, run-off areas, stands.

#include "orthodrive/core/random.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// Strip along a stretch of a line, between two distances from it, positive to the left. s may go beyond the seam of a
/// closed one.
[[nodiscard]] Ring strip_along(const Alignment& alignment, double s_begin_m, double s_end_m, double near_m,
                               double far_m);

/// Adds mown verges to both sides of a road.
void add_verges(SitePlan& plan, std::size_t road, double width_m);

/// Adds run-off areas outside the bends of a road: gravel traps, on some bends paved aprons.
void add_run_off(SitePlan& plan, std::size_t road, Random& random);

/// Adds tyre barriers behind the run-off areas of a road.
void add_barriers(SitePlan& plan, std::size_t road);

/// Adds up to `count` grandstands along the straights, where nothing else is within 10 m.
void add_stands(SitePlan& plan, std::size_t road, int count, Random& random);

}  // namespace orthodrive::synth
