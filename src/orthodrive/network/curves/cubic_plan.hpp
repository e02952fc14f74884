// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reference lines as parametric cubics (OpenDRIVE's paramPoly3): for lines that no chain of clothoids was found for.

#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Cubic spline through all points over their chord length (natural at the ends of open lines): continuous in place,
/// heading and curvature whatever the points. Closed lines repeat the first point at the end. s counts arc length;
/// within an element the parameter is only about proportional to it.
[[nodiscard]] std::vector<roadquery::PlanElement> cubic_plan(std::span<const Vec2> points, bool closed);

/// The part of an element with a ParamPoly3 from share p0 to share p1 of its parameter range, p0 > p1 for walking it
/// backwards.
[[nodiscard]] roadquery::PlanElement cubic_part(const roadquery::PlanElement& element, double p0, double p1);

}  // namespace orthodrive::network
