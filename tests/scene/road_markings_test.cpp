// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_markings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

double area_m2(const MarkingPiece& p) {
  const auto& c = p.corners;
  return 0.5 * (cross(c[1] - c[0], c[2] - c[0]) + cross(c[2] - c[0], c[3] - c[0]));
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
    for (const Vec2 p : piece.corners) EXPECT_NEAR(std::abs(p.y), 0.06, 1e-9);
}

TEST(RoadMarkings, edge_lines_lie_inside_the_outermost_lanes) {
  const auto pieces = road_markings(road_with({.start = {0.0, 0.0}}, "none", "solid"));
  EXPECT_NEAR(area_m2(pieces), 2.0 * 100.0 * 0.20, 1e-9);
  for (const MarkingPiece& piece : pieces) {
    for (const Vec2 p : piece.corners) {
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
    const auto& c = pieces[i].corners;
    const Vec2 middle = (c[0] + c[1] + c[2] + c[3]) * 0.25;
    EXPECT_NEAR(distance(middle, {0.0, radius_m}), radius_m, 0.01);
    if (i > 0) {
      EXPECT_LT(distance(pieces[i - 1].corners[1], c[0]), 1e-9);
      EXPECT_LT(distance(pieces[i - 1].corners[2], c[3]), 1e-9);
    }
  }
}

TEST(RoadMarkings, curbs_and_nothing_are_no_paint) {
  for (const char* none : {"curb", "grass", "edge", "custom", ""})
    EXPECT_TRUE(road_markings(road_with({.start = {0.0, 0.0}}, "none", none)).empty()) << none;
}

double most_left_m(const std::vector<MarkingPiece>& pieces) {
  double most = -1e9;
  for (const MarkingPiece& piece : pieces)
    for (const Vec2 p : piece.corners) most = std::max(most, p.y);
  return most;
}

TEST(RoadMarkings, two_lines_lie_beside_each_other_as_the_type_names_them) {
  const double solid_m2 = 100.0 * 0.12, broken_m2 = (11 * 3.0 + 1.0) * 0.12;
  const auto center = [](const char* type) { return road_markings(road_with({.start = {0.0, 0.0}}, type, "none")); };
  EXPECT_NEAR(area_m2(center("solid solid")), 2 * solid_m2, 1e-9);
  EXPECT_NEAR(area_m2(center("broken broken")), 2 * broken_m2, 1e-9);
  EXPECT_NEAR(most_left_m(center("solid solid")), 0.18, 1e-9);
  for (const bool solid_is_left : {false, true}) {  // of the centre lane from the left to the right
    const auto pieces = center(solid_is_left ? "solid broken" : "broken solid");
    EXPECT_NEAR(area_m2(pieces), solid_m2 + broken_m2, 1e-9);
    for (const MarkingPiece& piece : pieces)
      if (distance(piece.corners[0], piece.corners[1]) > 4.0) {
        EXPECT_EQ(piece.corners[0].y > 0.0, solid_is_left) << "strokes of the broken line are 3 m long";
      }
  }
  // Of the others from the inside outwards.
  for (const bool left : {false, true}) {
    roadquery::Road road = road_with({.start = {0.0, 0.0}}, "none", "none");
    auto& lanes = left ? road.sections[0].left : road.sections[0].right;
    lanes.push_back({.id = left ? 2 : -2, .width = {{.a = 3.0}}});
    lanes[0].marks = {{0.0, "solid broken", 0.12}};
    int of_solid = 0;
    for (const MarkingPiece& piece : road_markings(road))
      if (distance(piece.corners[0], piece.corners[1]) > 4.0) {
        EXPECT_LT(std::abs(piece.corners[0].y), 3.0) << left;
        ++of_solid;
      }
    EXPECT_GE(of_solid, 20);
  }
}

TEST(RoadMarkings, strokes_of_damaged_files_end_and_stay_on_the_road) {
  roadquery::Road road = road_with({.start = {0.0, 0.0}}, "none", "none");
  const auto painted_m2 = [&](const roadquery::RoadMarkLine& line) {
    road.sections[0].center.marks = {{0.0, "custom", 0.1, "white", {line}}};
    const auto pieces = road_markings(road);
    for (const MarkingPiece& piece : pieces)
      for (const Vec2 p : piece.corners) EXPECT_TRUE(p.x > -1e-9 && p.x < 100.0 + 1e-9) << p.x;
    return area_m2(pieces);
  };
  EXPECT_NEAR(painted_m2({.length = 1e-12, .space = 1e-12}), 100.0 * 0.1, 1e-9);
  EXPECT_NEAR(painted_m2({.length = 3.0, .space = 7.0, .s_offset = -1e12}), 10 * 3.0 * 0.1, 1e-3);
  EXPECT_NEAR(painted_m2({.length = 3.0, .s_offset = -1e12}), 100.0 * 0.1, 1e-9);
  EXPECT_EQ(painted_m2({.length = 3.0, .s_offset = -1e12, .is_single_stroke = true}), 0.0);
  EXPECT_EQ(painted_m2({.length = 3.0, .space = 7.0, .s_offset = 1e12}), 0.0);
}

TEST(RoadMarkings, lines_that_are_written_out_count_before_the_type) {
  roadquery::Road road = road_with({.start = {0.0, 0.0}}, "none", "none");
  road.sections[0].center.marks = {{10.0,
                                    "custom",
                                    0.12,
                                    "yellow",
                                    {{2.0, 8.0, 0.5, 1.0, 0.2, "", false}, {3.0, 0.0, -0.5, 20.0, 0.0, "blue", true}}}};
  const auto pieces = road_markings(road);
  EXPECT_NEAR(area_m2(pieces), 9 * 2.0 * 0.2 + 3.0 * 0.12, 1e-9) << "nine strokes from 11 m on, and one from 30 m on";
  EXPECT_NEAR(most_left_m(pieces), 0.6, 1e-9);
  for (const MarkingPiece& piece : pieces) {
    const bool is_left = piece.corners[0].y > 0.0;
    EXPECT_EQ(piece.color, paint_color(is_left ? "yellow" : "blue"));
    const double s = piece.corners[0].x - (is_left ? 11.0 : 30.0);
    EXPECT_NEAR(std::remainder(s, 10.0), 0.0, 1e-9);
  }
}

TEST(RoadMarkings, dots_are_as_long_as_wide) {
  EXPECT_NEAR(area_m2(road_markings(road_with({.start = {0.0, 0.0}}, "botts dots", "none"))), 84 * 0.01, 1e-9);
}

TEST(RoadMarkings, a_lane_of_no_width_has_no_line) {
  roadquery::Road road = road_with({.start = {0.0, 0.0}}, "none", "none");
  road.sections[0].left.push_back({.id = 2, .width = {{}}, .marks = {{0.0, "solid", 0.12}}});
  EXPECT_TRUE(road_markings(road).empty());
}

}  // namespace
}  // namespace orthodrive::scene
