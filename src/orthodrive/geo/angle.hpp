// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

namespace orthodrive {

/// The same direction between -pi and pi, radians.
[[nodiscard]] inline double wrapped_angle(double angle_rad) {
  return std::remainder(angle_rad, 2.0 * std::numbers::pi);
}

}  // namespace orthodrive
