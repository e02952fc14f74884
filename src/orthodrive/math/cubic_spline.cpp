// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/cubic_spline.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

#include "orthodrive/math/tridiagonal.hpp"

namespace orthodrive {
namespace {

/// The slopes on both sides of a knot are equal: h0 / 6 m[i - 1] + (h0 + h1) / 3 m[i] + h1 / 6 m[i + 1] = out - in,
/// with the second derivatives m and the slopes of the chords in and out.
TridiagonalRow knot_row(double h0, double h1, double in, double out) {
  return {h0 / 6.0, (h0 + h1) / 3.0, h1 / 6.0, out - in};
}

std::size_t interval(const std::vector<double>& knots, double s) {
  const auto it = std::upper_bound(knots.begin(), knots.end(), s);
  return std::min(static_cast<std::size_t>(std::max<long>(0, it - knots.begin() - 1)), knots.size() - 2);
}

}  // namespace

CubicSpline natural_spline(std::vector<double> s, std::vector<double> z) {
  assert(s.size() >= 2 && s.size() == z.size());
  const std::size_t n = s.size();
  std::vector<TridiagonalRow> rows(n);
  rows.front().diagonal = rows.back().diagonal = 1.0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = s[i] - s[i - 1], h1 = s[i + 1] - s[i];
    rows[i] = knot_row(h0, h1, (z[i] - z[i - 1]) / h0, (z[i + 1] - z[i]) / h1);
  }
  return {std::move(s), std::move(z), solve_tridiagonal(std::move(rows))};
}

CubicSpline clamped_spline(std::vector<double> s, std::vector<double> z, double first_slope, double last_slope) {
  assert(s.size() >= 2 && s.size() == z.size());
  const std::size_t n = s.size();
  std::vector<TridiagonalRow> rows(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double h0 = i > 0 ? s[i] - s[i - 1] : 0.0, h1 = i + 1 < n ? s[i + 1] - s[i] : 0.0;
    const double in = i > 0 ? (z[i] - z[i - 1]) / h0 : first_slope;
    const double out = i + 1 < n ? (z[i + 1] - z[i]) / h1 : last_slope;
    rows[i] = knot_row(h0, h1, in, out);
  }
  return {std::move(s), std::move(z), solve_tridiagonal(std::move(rows))};
}

CubicSpline periodic_spline(std::vector<double> s, std::vector<double> z) {
  assert(s.size() >= 3 && s.size() == z.size());
  const std::size_t n = s.size() - 1;  // unknowns: the last knot is the first
  std::vector<TridiagonalRow> rows(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : n - 1;
    const double h0 = s[before + 1] - s[before], h1 = s[i + 1] - s[i];
    rows[i] = knot_row(h0, h1, (z[before + 1] - z[before]) / h0, (z[i + 1] - z[i]) / h1);
  }
  std::vector<double> second = solve_tridiagonal(std::move(rows), true);
  second.push_back(second.front());
  return {std::move(s), std::move(z), std::move(second)};
}

double CubicSpline::at(double s) const {
  const std::size_t i = interval(knots, s);
  const double h = knots[i + 1] - knots[i], a = (knots[i + 1] - s) / h, b = 1.0 - a;
  return a * values[i] + b * values[i + 1] +
         ((a * a * a - a) * second[i] + (b * b * b - b) * second[i + 1]) * h * h / 6.0;
}

double CubicSpline::slope(double s) const {
  const std::size_t i = interval(knots, s);
  const double h = knots[i + 1] - knots[i], a = (knots[i + 1] - s) / h, b = 1.0 - a;
  return (values[i + 1] - values[i]) / h +
         ((3.0 * b * b - 1.0) * second[i + 1] - (3.0 * a * a - 1.0) * second[i]) * h / 6.0;
}

double CubicSpline::bend(double s) const {
  const std::size_t i = interval(knots, s);
  const double h = knots[i + 1] - knots[i], b = (s - knots[i]) / h;
  return (1.0 - b) * second[i] + b * second[i + 1];
}

}  // namespace orthodrive
