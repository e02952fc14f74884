// SPDX-License-Identifier: Apache-2.0
#pragma once
// The circle that lies best beside points: how roundabouts are recognised and completed.

#include <optional>
#include <span>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::network {

struct Circle {
  Vec2 center;
  double radius_m = 0.0, error_m = 0.0;  ///< error: root mean square of the distances from it
};

/// Least squares circle; none for points on a line.
[[nodiscard]] std::optional<Circle> fit_circle(std::span<const Vec2> points);

}  // namespace orthodrive::network
