// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/cubic_spline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "orthodrive/math/tridiagonal.hpp"

namespace orthodrive {
namespace {

const std::vector<double> uneven = {0.0, 1.0, 1.5, 4.0, 7.0, 7.5, 10.0};

std::vector<double> values_of(const std::vector<double>& knots, const std::function<double(double)>& f) {
  std::vector<double> values;
  for (const double s : knots) values.push_back(f(s));
  return values;
}

/// Value, slope and second derivative do not jump at the inner knots.
void expect_c2(const CubicSpline& spline) {
  constexpr double e = 1e-9;
  for (std::size_t i = 0; i < spline.knots.size(); ++i) {
    const double s = spline.knots[i];
    EXPECT_NEAR(spline.at(s), spline.values[i], 1e-12);
    EXPECT_NEAR(spline.bend(s), spline.second[i], 1e-12);
    if (i == 0 || i + 1 == spline.knots.size()) continue;
    EXPECT_NEAR(spline.at(s - e), spline.at(s + e), 1e-7);
    EXPECT_NEAR(spline.slope(s - e), spline.slope(s + e), 1e-7);
    EXPECT_NEAR(spline.bend(s - e), spline.bend(s + e), 1e-7);
  }
}

TEST(CubicSpline, clamped_reproduces_a_cubic) {
  const auto f = [](double s) { return 2.0 - s + 0.3 * s * s - 0.02 * s * s * s; };
  const auto slope = [](double s) { return -1.0 + 0.6 * s - 0.06 * s * s; };
  const CubicSpline spline = clamped_spline(uneven, values_of(uneven, f), slope(0.0), slope(10.0));
  for (double s = -1.0; s <= 11.0; s += 0.25) {  // outside the knots the end pieces go on
    EXPECT_NEAR(spline.at(s), f(s), 1e-10) << s;
    EXPECT_NEAR(spline.slope(s), slope(s), 1e-10) << s;
    EXPECT_NEAR(spline.bend(s), 0.6 - 0.12 * s, 1e-10) << s;
  }
}

TEST(CubicSpline, natural_is_c2_without_curvature_at_its_ends) {
  const CubicSpline spline = natural_spline(uneven, values_of(uneven, [](double s) { return std::sin(s); }));
  expect_c2(spline);
  EXPECT_EQ(spline.second.front(), 0.0);
  EXPECT_EQ(spline.second.back(), 0.0);
}

TEST(CubicSpline, two_knots_make_a_line) {
  const CubicSpline spline = natural_spline({1.0, 3.0}, {5.0, 9.0});
  EXPECT_DOUBLE_EQ(spline.at(2.0), 7.0);
  EXPECT_DOUBLE_EQ(spline.slope(2.5), 2.0);
}

TEST(CubicSpline, periodic_goes_on_in_itself) {
  const double round = 2.0 * std::numbers::pi;
  std::vector<double> knots;
  for (int i = 0; i <= 24; ++i) knots.push_back(round * (i + (i % 24 == 0 ? 0.0 : 0.2 * std::sin(3.0 * i))) / 24.0);
  std::vector<double> values = values_of(knots, [](double s) { return std::sin(s); });
  values.back() = values.front();
  const CubicSpline spline = periodic_spline(knots, values);
  expect_c2(spline);
  EXPECT_NEAR(spline.slope(0.0), spline.slope(round), 1e-12);
  EXPECT_EQ(spline.second.front(), spline.second.back());
  for (double s = 0.0; s < round; s += 0.1) EXPECT_NEAR(spline.at(s), std::sin(s), 1e-3) << s;
}

TEST(CubicSpline, periodic_equals_the_middle_of_many_rounds_of_a_natural_one) {
  const std::vector<double> knots = {0.0, 2.0, 3.0, 7.0}, values = {1.0, 4.0, -2.0, 1.0};
  std::vector<double> long_knots, long_values;
  for (int round = 0; round < 31; ++round)
    for (std::size_t i = 0; i < 3; ++i) long_knots.push_back(7.0 * round + knots[i]), long_values.push_back(values[i]);
  const CubicSpline once = periodic_spline(knots, values), many = natural_spline(long_knots, long_values);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(once.second[i], many.second[45 + i], 1e-12);
}

TEST(Tridiagonal, cyclic_rows_are_fulfilled) {
  std::vector<TridiagonalRow> rows;
  for (int i = 0; i < 9; ++i) rows.push_back({0.3 + 0.1 * i, 4.0 - 0.1 * i, -0.7 + 0.05 * i, 1.0 + i * i});
  const std::vector<double> x = solve_tridiagonal(rows, true);
  for (std::size_t i = 0; i < 9; ++i) {
    const double left = rows[i].below * x[(i + 8) % 9] + rows[i].diagonal * x[i] + rows[i].above * x[(i + 1) % 9];
    EXPECT_NEAR(left, rows[i].right, 1e-12);
  }
}

TEST(Tridiagonal, open_rows_are_fulfilled) {
  const std::vector<TridiagonalRow> rows = {{0.0, 2.0, 1.0, 4.0}, {-1.0, 3.0, 0.5, 6.5}, {1.0, 5.0, 0.0, 17.0}};
  const std::vector<double> x = solve_tridiagonal(rows);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(x[i], static_cast<double>(i) + 1.0, 1e-12);
}

}  // namespace
}  // namespace orthodrive
