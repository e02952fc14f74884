// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/overlay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <span>
#include <utility>

namespace orthodrive {
namespace {

constexpr double grid_m = 1e-3;

Ring square(double x, double y, double size) { return {{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}}; }

double area_m2(const MultiPolygon& polygons) {
  double sum = 0.0;
  for (const Polygon& polygon : polygons) sum += orthodrive::area_m2(polygon);
  return sum;
}

TEST(Overlay, union_counts_what_overlaps_once) {
  const std::vector<Polygon> squares = {{square(0, 0, 2), {}}, {square(1, 1, 2), {}}, {square(10, 10, 1), {}}};
  const MultiPolygon joined = union_of(squares, grid_m);
  EXPECT_EQ(joined.size(), 2U);
  EXPECT_NEAR(area_m2(joined), 8.0, 1e-9);
}

TEST(Overlay, outer_rings_turn_left_and_holes_right_whatever_the_input) {
  Ring clockwise = square(0, 0, 4);
  std::reverse(clockwise.begin(), clockwise.end());
  const std::vector<Polygon> frame = {{clockwise, {square(1, 1, 2)}}};
  const MultiPolygon joined = union_of(frame, grid_m);
  ASSERT_EQ(joined.size(), 1U);
  ASSERT_EQ(joined[0].holes.size(), 1U);
  EXPECT_NEAR(signed_area_m2(joined[0].outer), 16.0, 1e-9);
  EXPECT_NEAR(signed_area_m2(joined[0].holes[0]), -4.0, 1e-9);
}

TEST(Overlay, intersection_and_difference_share_out_the_area) {
  const MultiPolygon a = {{square(0, 0, 2), {}}}, b = {{square(1, 0, 2), {}}};
  EXPECT_NEAR(area_m2(intersection_of(a, b, grid_m)), 2.0, 1e-9);
  EXPECT_NEAR(area_m2(difference_of(a, b, grid_m)), 2.0, 1e-9);
  EXPECT_NEAR(area_m2(difference_of(b, a, grid_m)), 2.0, 1e-9);
}

TEST(Overlay, polygons_that_only_touch_share_nothing) {  // GEOS answers with a line: it is left out
  const MultiPolygon a = {{square(0, 0, 1), {}}}, b = {{square(1, 0, 1), {}}};
  EXPECT_TRUE(intersection_of(a, b, grid_m).empty());
  EXPECT_TRUE(intersection_of(a, {}, grid_m).empty());
  EXPECT_NEAR(area_m2(difference_of(a, {}, grid_m)), 1.0, 1e-9);
  EXPECT_TRUE(union_of({}, grid_m).empty());
}

TEST(Overlay, polygons_that_fold_over_themselves_are_made_valid) {
  const std::vector<Polygon> bow_tie = {{{{0, 0}, {2, 2}, {2, 0}, {0, 2}}, {}}};
  EXPECT_FALSE(is_simple(bow_tie[0].outer));
  EXPECT_TRUE(is_simple(square(0, 0, 1)));
  EXPECT_FALSE(is_simple({{0, 0}, {1, 0}}));
  EXPECT_NEAR(area_m2(union_of(bow_tie, grid_m)), 2.0, 1e-9);
  EXPECT_NEAR(area_m2(intersection_of(bow_tie, {{square(0, 0, 1), {}}}, grid_m)), 0.5, 1e-9);
}

TEST(Overlay, results_lie_on_the_grid) {
  const double grid = 1.0 / 1024.0;
  const std::vector<Polygon> turned = {{{{0.0003, 0}, {2.1, 0.7001}, {1.3, 2.9}}, {}}, {square(0.5, 0.5, 1.7), {}}};
  for (const Polygon& polygon : union_of(turned, grid))
    for (const Vec2 p : polygon.outer)
      for (const double v : {p.x, p.y}) EXPECT_EQ(std::round(v / grid) * grid, v);
}

TEST(Overlay, a_union_of_a_single_polygon_lies_on_the_grid) {
  const Polygon off_grid{{{0.00012, 0.00047}, {5.00033, 0.1}, {2.7, 7.00018}}, {}};
  const MultiPolygon joined = union_of(std::span(&off_grid, 1), grid_m);
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_NEAR(orthodrive::area_m2(joined[0]), orthodrive::area_m2(off_grid), 0.01);
  for (const Vec2 p : joined[0].outer) {
    EXPECT_NEAR(p.x, std::round(p.x / grid_m) * grid_m, 1e-12);
    EXPECT_NEAR(p.y, std::round(p.y / grid_m) * grid_m, 1e-12);
  }
}

TEST(NodeLines, segments_meet_at_their_ends_only_and_come_once) {
  const std::vector<Polyline> lines = {{{0, 0}, {4, 0}}, {{2, -2}, {2, 2}}, {{4, 0}, {0, 0}}, {{1, 0}, {3, 0}}};
  std::set<std::pair<double, double>> middles;
  double length = 0.0;
  for (const LineSegment& segment : node_lines(lines, grid_m)) {
    const Vec2 middle = (segment.a + segment.b) * 0.5;
    EXPECT_TRUE(middles.emplace(middle.x, middle.y).second);
    length += distance(segment.a, segment.b);
  }
  EXPECT_EQ(middles.size(), 6U);  // four of the axis, two of the line across
  EXPECT_NEAR(length, 8.0, 1e-9);
}

}  // namespace
}  // namespace orthodrive
