// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/bounded_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "paths.hpp"

namespace orthodrive {
namespace {

constexpr double pi = std::numbers::pi;
constexpr LineCosts curvature_only{.curvature_m4 = 1e4};

LineBetweenEdges between(Polyline reference, bool closed, double half_m) {
  LineBetweenEdges task{.closed = closed, .reference = std::move(reference)};
  task.lower_m.assign(task.reference.size(), -half_m);
  task.upper_m.assign(task.reference.size(), half_m);
  task.wanted_m.assign(task.reference.size(), 0.0);
  return task;
}

Polyline circle(double radius_m) {
  const auto n = static_cast<std::size_t>(2.0 * pi * radius_m);
  Polyline line;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2.0 * pi * static_cast<double>(i) / static_cast<double>(n);
    line.push_back({radius_m * std::cos(angle), radius_m * std::sin(angle)});
  }
  return line;
}

/// East, then a bend to the left by `turn_rad` with that radius, then straight on; a point a metre.
Polyline bend(double straight_m, double radius_m, double turn_rad) {
  Polyline line;
  Vec2 p;
  double heading = 0.0;
  const double arc_m = radius_m * turn_rad, total_m = 2.0 * straight_m + arc_m;
  for (double s = 0.0; s <= total_m; s += 1.0) {
    line.push_back(p);
    if (s >= straight_m && s < straight_m + arc_m) heading += 1.0 / radius_m;
    p = p + Vec2{std::cos(heading), std::sin(heading)};
  }
  return line;
}

double largest_curvature(const LineBetweenEdges& task, const std::vector<double>& offset) {
  const std::vector<Vec2> normals = left_normals(task.reference, task.closed);
  double most = 0.0;
  const auto at = [&](std::size_t i) { return task.reference[i] + offset[i] * normals[i]; };
  for (std::size_t i = 1; i + 1 < offset.size(); ++i)
    most = std::max(most, std::abs(curvature_of(at(i - 1), at(i), at(i + 1))));
  return most;
}

TEST(BestOffsets, on_an_annulus_the_outer_circle_has_least_curvature) {
  const std::vector<double> offset = best_offsets(between(circle(50.0), true, 5.0), curvature_only);
  for (const double p : offset) ASSERT_NEAR(p, -5.0, 1e-3);  // the circle runs left: its outside is right
}

TEST(BestOffsets, a_bend_is_driven_from_outside_over_its_apex_to_outside) {
  const LineBetweenEdges task = between(bend(150.0, 30.0, pi / 2.0), false, 4.0);
  const std::vector<double> offset = best_offsets(task, curvature_only);
  const std::size_t apex = offset.size() / 2;
  EXPECT_NEAR(offset[apex], 4.0, 0.01);
  EXPECT_NEAR(*std::min_element(offset.begin(), offset.begin() + static_cast<std::ptrdiff_t>(apex)), -4.0, 0.01);
  EXPECT_NEAR(*std::min_element(offset.begin() + static_cast<std::ptrdiff_t>(apex), offset.end()), -4.0, 0.01);
  for (const double p : offset) ASSERT_LE(std::abs(p), 4.0 + 1e-3);
  // Symmetric, as the bend is.
  for (std::size_t i = 20; i < apex; ++i) ASSERT_NEAR(offset[i], offset[offset.size() - 1 - i], 0.5) << i;
  // No arc that touches outside, inside, outside is wider than this one: R + w (1 + cos) / (1 - cos), half the turn.
  const double half_turn = std::cos(pi / 4.0), widest_m = 34.0 + 8.0 * half_turn / (1.0 - half_turn);
  EXPECT_LT(largest_curvature(task, offset), 1.0 / 40.0);
  EXPECT_GT(largest_curvature(task, offset), 0.9 / widest_m);
}

TEST(BestOffsets, what_is_wanted_is_kept_where_nothing_speaks_against_it) {
  LineBetweenEdges task = between(bend(100.0, 40.0, 1.0), false, 2.0);
  std::fill(task.wanted_m.begin(), task.wanted_m.end(), 0.7);
  for (const double p : best_offsets(task, {.offset = 1.0})) ASSERT_NEAR(p, 0.7, 1e-6);
  std::fill(task.wanted_m.begin(), task.wanted_m.end(), 5.0);
  for (const double p : best_offsets(task, {.offset = 1.0})) ASSERT_NEAR(p, 2.0, 1e-6);
}

TEST(BestOffsets, a_pinch_is_passed_and_a_gap_of_nothing_holds_the_line) {
  LineBetweenEdges task = between(bend(200.0, 1e6, 0.0), false, 3.0);
  for (std::size_t i = 198; i < 203; ++i) task.lower_m[i] = task.upper_m[i] = 2.0;
  const std::vector<double> offset = best_offsets(task, {.curvature_m4 = 1e4, .curvature_rate_m6 = 1e4});
  for (std::size_t i = 198; i < 203; ++i) EXPECT_NEAR(offset[i], 2.0, 1e-3);
  for (const double p : offset) ASSERT_LE(std::abs(p), 3.0 + 1e-3);
}

/// Rows of numbers of a CSV file with # comments.
std::vector<std::vector<double>> rows_of(const std::string& file) {
  std::vector<std::vector<double>> rows;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0.0; words >> value;) row.push_back(value);
    rows.push_back(row);
  }
  return rows;
}

/// Integral of the squared curvature of a closed line, 1/m.
double bending(const Polyline& line) {
  double sum = 0.0;
  for (std::size_t n = line.size(), i = 0; i < n; ++i) {
    const double k = curvature_of(line[(i + n - 1) % n], line[i], line[(i + 1) % n]);
    sum += k * k * distance(line[i], line[(i + 1) % n]);
  }
  return sum;
}

TEST(BestOffsets, bends_as_little_as_the_published_minimum_curvature_line_of_the_red_bull_ring) {
  const std::string folder = paths::in_source("../shared/data/spielberg/").string();
  if (!std::filesystem::exists(folder + "raceline_min_curvature.csv")) GTEST_SKIP() << "no race line in " << folder;
  LineBetweenEdges task{.closed = true};
  for (const auto& row : rows_of(folder + "spielberg_utm33.csv")) {
    task.reference.push_back({row[0], row[1]});
    constexpr double half_car_m = 0.7;  // theirs keeps so far from the edges
    task.lower_m.push_back(half_car_m - row[2]), task.upper_m.push_back(row[3] - half_car_m);
    task.wanted_m.push_back(0.0);
  }
  const std::vector<double> offset = best_offsets(task, curvature_only);
  const std::vector<Vec2> normals = left_normals(task.reference, true);
  Polyline ours, theirs;
  for (std::size_t i = 0; i < offset.size(); ++i) ours.push_back(task.reference[i] + offset[i] * normals[i]);
  for (const auto& row : rows_of(folder + "raceline_min_curvature.csv")) theirs.push_back({row[0], row[1]});
  EXPECT_NEAR(bending(ours) / bending(theirs), 1.0, 0.03);
  // Where it bends there is one best place; on straights many lines are as good.
  double sum = 0.0, count = 0.0;
  for (std::size_t n = theirs.size(), i = 0; i < n; ++i) {
    if (std::abs(curvature_of(theirs[(i + n - 1) % n], theirs[i], theirs[(i + 1) % n])) < 0.01) continue;
    sum += project_onto(ours, theirs[i]).distance_m, count += 1.0;
  }
  std::printf("bending %.5f of theirs, mean distance in bends %.3f m\n", bending(ours) / bending(theirs), sum / count);
  EXPECT_LT(sum / count, 0.5);
}

}  // namespace
}  // namespace orthodrive
