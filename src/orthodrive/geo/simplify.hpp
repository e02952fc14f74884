// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lines with fewer points.

#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// Douglas and Peucker (1973): which points stay. No dropped point is farther than the tolerance from the line left.
/// Ends stay.
[[nodiscard]] std::vector<bool> simplify(std::span<const Vec2> line, double tolerance_m);

}  // namespace orthodrive
