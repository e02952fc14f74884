// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much like a circle a closed line is.

#include <numbers>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {

/// Isoperimetric quotient 4 pi area / length^2 of a ring whose last point is not its first: 1 of a circle, pi / 4 of a
/// square, negative clockwise.
[[nodiscard]] inline double roundness(Ring ring) {
  const double area_m2 = signed_area_m2(ring);
  ring.push_back(ring.front());
  const double round_m = length_m(ring);
  return 4.0 * std::numbers::pi * area_m2 / (round_m * round_m);
}

}  // namespace orthodrive
