#pragma once
// Cubic splines: heights and widths along a road.

#include <vector>

namespace orthodrive::synth {

/// Twice continuously differentiable, cubic between knots. Outside the knots the end pieces go on.
struct Spline {
  std::vector<double> knots, values, second;  ///< second derivatives at the knots
  [[nodiscard]] double at(double s) const;
  [[nodiscard]] double slope(double s) const;
  [[nodiscard]] double bend(double s) const;  ///< second derivative
};

/// Natural spline; `closed`: periodic, the last value repeats the first. Needs two ascending knots.
[[nodiscard]] Spline make_spline(std::vector<double> knots, std::vector<double> values, bool closed);

}  // namespace orthodrive::synth
