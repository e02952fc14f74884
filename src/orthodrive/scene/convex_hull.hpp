#pragma once

#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::scene {

/// Counter-clockwise, without points on its edges (Andrew's monotone chain). Fewer than three points when all lie on a
/// line.
[[nodiscard]] Ring convex_hull(std::vector<Vec2> points);

}  // namespace orthodrive::scene
