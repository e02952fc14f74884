// SPDX-License-Identifier: Apache-2.0
#pragma once
// Curves given by cubics of a parameter, walked by their length (OpenDRIVE 1.7, 8.6: the length of a <geometry> is that
// of its curve, and the parameter of a <paramPoly3> is neither that length nor in proportion to it).

#include <array>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// A place of an element's curve.
struct PolyPlace {
  double p = 0.0;
  double stretch = 1.0;  ///< length of the curve for each metre of the element's `length`: 1 but for rounding
};

/// The place `ds` metres along an element with a ParamPoly3, whose whole curve counts as long as the element says.
/// Beyond the ends the cubics go on.
[[nodiscard]] PolyPlace place_along(const PlanElement& element, const ParamPoly3& poly, double ds);

/// Length of the curve over its whole range of the parameter, m.
[[nodiscard]] double curve_length(const PlanElement& element, const ParamPoly3& poly);

/// A poly3 element (1.1 - 1.7, 8.5): v = a + b u + c u^2 + d u^3, `length_m` long, as a normalized ParamPoly3.
[[nodiscard]] ParamPoly3 from_poly3(const Cubic& v_of_u, double length_m);

/// Along the heading and to the left of it, coefficients of du to du^5 of the curve around a place, du metres of the
/// element's length. `turn_rad`: heading there in the element's frame.
struct PolySeries {
  std::array<double, 5> along{}, left{};
};
[[nodiscard]] PolySeries series_around(const ParamPoly3& poly, const PolyPlace& place, double turn_rad);

}  // namespace roadquery
