// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_markings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

double area_m2(const MarkingPiece& p) {
  return 0.5 * (cross(p[1] - p[0], p[2] - p[0]) + cross(p[2] - p[0], p[3] - p[0]));
}

double area_m2(const std::vector<MarkingPiece>& pieces) {
  double sum = 0.0;
  for (const MarkingPiece& piece : pieces) sum += area_m2(piece);
  return sum;
}

/// 6 m wide, two lanes.
roadquery::Road road_with(const scene_test::RoadShape& shape, const char* center, const char* edge) {
  roadquery::Road road = scene_test::make_road(1, shape);
  road.sections[0].center.marks = {{0.0, center, 0.12}};
  road.sections[0].left[0].marks = road.sections[0].right[0].marks = {{0.0, edge, 0.20}};
  return road;
}

TEST(RoadMarkings, solid_line_runs_along_the_whole_middle) {
  const auto pieces = road_markings(road_with({.start = {0.0, 0.0}}, "solid", "none"));
  EXPECT_NEAR(area_m2(pieces), 100.0 * 0.12, 1e-9);
  for (const MarkingPiece& piece : pieces)
    for (const Vec2 p : piece) EXPECT_NEAR(std::abs(p.y), 0.06, 1e-9);
}

TEST(RoadMarkings, edge_lines_lie_inside_the_outermost_lanes) {
  const auto pieces = road_markings(road_with({.start = {0.0, 0.0}}, "none", "solid"));
  EXPECT_NEAR(area_m2(pieces), 2.0 * 100.0 * 0.20, 1e-9);
  for (const MarkingPiece& piece : pieces) {
    for (const Vec2 p : piece) {
      EXPECT_LE(std::abs(p.y), 3.0 + 1e-9);
      EXPECT_GE(std::abs(p.y), 2.8 - 1e-9);
    }
  }
}

TEST(RoadMarkings, broken_line_has_strokes_and_gaps_of_the_speed) {
  roadquery::Road road = road_with({.start = {0.0, 0.0}, .length_m = 90.0}, "broken", "none");
  EXPECT_NEAR(area_m2(road_markings(road)), 10 * 3.0 * 0.12, 1e-9);  // none given: as in towns
  road.speed_limit_mps = 80.0 / 3.6;
  EXPECT_NEAR(area_m2(road_markings(road)), (7 * 4.0 + 4.0) * 0.12, 1e-9);  // 7 periods of 12 m, and one more stroke
  road.speed_limit_mps = 130.0 / 3.6;
  EXPECT_NEAR(area_m2(road_markings(road)), 5 * 6.0 * 0.12, 1e-9);
}

TEST(RoadMarkings, bends_are_followed_within_a_centimetre_and_pieces_meet) {
  const double radius_m = 20.0;
  const auto pieces = road_markings(
      road_with({.start = {0.0, 0.0}, .length_m = 60.0, .curvature_1pm = 1.0 / radius_m}, "solid", "none"));
  EXPECT_NEAR(area_m2(pieces), 60.0 * 0.12, 0.01);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    EXPECT_GT(area_m2(pieces[i]), 0.0);  // counter-clockwise
    const Vec2 middle = (pieces[i][0] + pieces[i][1] + pieces[i][2] + pieces[i][3]) * 0.25;
    EXPECT_NEAR(distance(middle, {0.0, radius_m}), radius_m, 0.01);
    if (i > 0) {
      EXPECT_LT(distance(pieces[i - 1][1], pieces[i][0]), 1e-9);
      EXPECT_LT(distance(pieces[i - 1][2], pieces[i][3]), 1e-9);
    }
  }
}

TEST(RoadMarkings, curbs_and_nothing_are_no_paint) {
  EXPECT_TRUE(road_markings(road_with({.start = {0.0, 0.0}}, "none", "curb")).empty());
}

TEST(RoadMarkings, a_lane_of_no_width_has_no_line) {
  roadquery::Road road = road_with({.start = {0.0, 0.0}}, "none", "none");
  road.sections[0].left.push_back({.id = 2, .width = {{}}, .marks = {{0.0, "solid", 0.12}}});
  EXPECT_TRUE(road_markings(road).empty());
}

}  // namespace
}  // namespace orthodrive::scene
