// SPDX-License-Identifier: Apache-2.0
#pragma once
// The uniform cubic B-spline: C2, four coefficients a place. (de Boor, A practical guide to splines, 1978, ch. X)

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace orthodrive {

struct UniformSpline {
  double length_m = 0.0;
  int intervals = 1;

  UniformSpline() = default;
  /// Intervals of at most `spacing_m` over [0, length].
  UniformSpline(double length, double spacing_m)
      : length_m(length), intervals(std::max(1, static_cast<int>(std::ceil(length / spacing_m)))) {}

  [[nodiscard]] int coefficients() const { return intervals + 3; }
  [[nodiscard]] double step_m() const { return length_m / intervals; }

  struct Basis {
    int first = 0;                                           ///< the coefficients first ... first + 3 count
    std::array<double, 4> value{}, slope{}, bend{}, jerk{};  ///< basis functions and their first to third derivatives
  };
  [[nodiscard]] Basis at(double s_m) const {
    const double h = step_m(), x = std::clamp(s_m / h, 0.0, static_cast<double>(intervals));
    Basis basis{.first = std::min(intervals - 1, static_cast<int>(x))};
    const double u = x - basis.first, v = 1.0 - u;
    basis.value = {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
                   (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0, u * u * u / 6.0};
    basis.slope = {-v * v / 2.0 / h, (-4.0 * u + 3.0 * u * u) / 2.0 / h, (4.0 * v - 3.0 * v * v) / 2.0 / h,
                   u * u / 2.0 / h};
    basis.bend = {v / (h * h), (3.0 * u - 2.0) / (h * h), (3.0 * v - 2.0) / (h * h), u / (h * h)};
    basis.jerk = {-1.0 / (h * h * h), 3.0 / (h * h * h), -3.0 / (h * h * h), 1.0 / (h * h * h)};
    return basis;
  }
};

}  // namespace orthodrive
