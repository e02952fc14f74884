// SPDX-License-Identifier: Apache-2.0
#pragma once
// Spring, damper and stops of one wheel.

#include <algorithm>
#include <cmath>

#include "vehicle/car_parameters.hpp"

namespace vehicle {

/// Force of spring and stops at the wheel beyond the one at rest, positive = pushes the wheel down (away from the
/// body).
inline double spring_n(const Suspension& s, double travel_m) {
  double force = travel_m * (s.spring_npm + s.spring_cubic_npm3 * travel_m * travel_m);
  if (travel_m > s.bump_stop_m) force += s.stop_stiffness_npm * (travel_m - s.bump_stop_m);
  if (travel_m < -s.rebound_stop_m) force += s.stop_stiffness_npm * (travel_m + s.rebound_stop_m);
  return force;
}

/// Energy in J of that spring.
inline double spring_j(const Suspension& s, double travel_m) {
  const double square = travel_m * travel_m;
  double energy = 0.5 * s.spring_npm * square + 0.25 * s.spring_cubic_npm3 * square * square;
  const double bump = std::max(travel_m - s.bump_stop_m, 0.0), rebound = std::max(-travel_m - s.rebound_stop_m, 0.0);
  energy += 0.5 * s.stop_stiffness_npm * (bump * bump + rebound * rebound);
  return energy;
}

/// Force of the damper, positive against bump: two straight lines with a knee, in each direction.
inline double damper_n(const Suspension& s, double rate_mps) {
  const double slope = rate_mps > 0.0 ? s.bump_damping_nspm : s.rebound_damping_nspm;
  const double slow = std::clamp(rate_mps, -s.damper_knee_mps, s.damper_knee_mps);
  return slope * (slow + s.damper_fast_ratio * (rate_mps - slow));
}

}  // namespace vehicle
