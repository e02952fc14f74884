// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "roadquery/surface/road_surface.hpp"

namespace roadquery {

/// Rise per metre of way in plan towards the heading `hdg` (rad) of the surface at a point. On a banked road this is
/// not the derivative of its heights by s: it is what roads that meet there share, wherever their reference lines lie.
[[nodiscard]] inline double gradient_towards(const SurfacePoint& point, double hdg) {
  return -(std::cos(hdg) * point.normal[0] + std::sin(hdg) * point.normal[1]) / point.normal[2];
}

}  // namespace roadquery
