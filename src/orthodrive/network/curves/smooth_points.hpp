// SPDX-License-Identifier: Apache-2.0
#pragma once
// Noise out of a line of nodes before curvature is taken from it.

#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::network {

/// The line q with the smallest  integral |q - p|^2 + lambda integral |q'''|^2  (a penalised spline; waves of
/// `cutoff_m` keep half their height, twice as long ones 98 %, half as long ones 2 %), with more weight on nodes that
/// it would leave by more than `reach_m`: sharp bends keep their place. Closed lines do not repeat their first point.
/// Lines of fewer than four points stay as they are.
[[nodiscard]] std::vector<Vec2> smooth_points(std::span<const Vec2> points, bool closed, double cutoff_m,
                                              double reach_m);

}  // namespace orthodrive::network
