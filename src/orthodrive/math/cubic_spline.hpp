// SPDX-License-Identifier: Apache-2.0
#pragma once
// The cubic spline through values at any knots: twice continuously differentiable.
// (de Boor, A Practical Guide to Splines, 1978, ch. IV)

#include <vector>

namespace orthodrive {

/// Outside the knots the end pieces go on.
struct CubicSpline {
  std::vector<double> knots, values, second;  ///< second derivatives at the knots
  [[nodiscard]] double at(double s) const;
  [[nodiscard]] double slope(double s) const;
  [[nodiscard]] double bend(double s) const;  ///< second derivative
};

/// All need two ascending knots. Natural: no curvature at the ends.
[[nodiscard]] CubicSpline natural_spline(std::vector<double> knots, std::vector<double> values);
[[nodiscard]] CubicSpline clamped_spline(std::vector<double> knots, std::vector<double> values, double first_slope,
                                         double last_slope);
/// Goes on in itself: the last value repeats the first. Needs three knots.
[[nodiscard]] CubicSpline periodic_spline(std::vector<double> knots, std::vector<double> values);

}  // namespace orthodrive
