// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_paint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

double summed_m2(const std::vector<MarkingPiece>& pieces) {
  double sum = 0.0;
  for (const auto& [p, color] : pieces) {
    const double area = 0.5 * (cross(p[1] - p[0], p[2] - p[0]) + cross(p[2] - p[0], p[3] - p[0]));
    EXPECT_GT(area, 0.0) << "counter-clockwise";
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_GE(cross(p[(i + 1) % 4] - p[i], p[(i + 2) % 4] - p[i]), -1e-9) << "convex";
    sum += area;
  }
  return sum;
}

/// Straight along x from the origin, 100 m long and 6 m wide.
roadquery::Road road_with(const roadquery::RoadObject& object) {
  roadquery::Road road = scene_test::make_road(1, {.start = {0.0, 0.0}});
  road.objects = {object};
  return road;
}

Box2 bounds_of(const std::vector<MarkingPiece>& pieces) {
  Box2 box{1e9, 1e9, -1e9, -1e9};
  for (const MarkingPiece& piece : pieces)
    for (const Vec2 p : piece.corners)
      box = {std::min(box.min_x, p.x), std::min(box.min_y, p.y), std::max(box.max_x, p.x), std::max(box.max_y, p.y)};
  return box;
}

TEST(RoadPaint, zebra_has_bars_along_the_road_as_many_as_fit) {
  roadquery::RoadObject zebra{.type = "crosswalk", .subtype = "zebra"};
  zebra.outline = {{48.0, -3.0}, {52.0, -3.0}, {52.0, 3.0}, {48.0, 3.0}};
  const auto pieces = road_paint(road_with(zebra));
  EXPECT_NEAR(summed_m2(pieces), 6 * 0.5 * 4.0, 1e-9) << "six bars with five gaps in 6 m";
  const Box2 box = bounds_of(pieces);
  EXPECT_NEAR(box.min_x, 48.0, 1e-9);
  EXPECT_NEAR(box.max_x, 52.0, 1e-9);
  EXPECT_NEAR(box.max_y, 2.75, 1e-9) << "in the middle";
  EXPECT_NEAR(box.min_y, -2.75, 1e-9);
  zebra.subtype.clear();
  EXPECT_NEAR(summed_m2(road_paint(road_with(zebra))), 6 * 0.5 * 4.0, 1e-9) << "OpenDRIVE before 1.7 has no subtypes";
  zebra.subtype = "virtual";
  EXPECT_TRUE(road_paint(road_with(zebra)).empty());
  zebra.subtype = "pedestrian";
  EXPECT_NEAR(summed_m2(road_paint(road_with(zebra))), 2 * 8 * 0.5 * 0.12, 1e-9) << "eight strokes and gaps of 0.7 m";
}

/// From nothing at 20 m to 3 m at 50 m, left of the road's edge.
roadquery::RoadObject gore() {
  roadquery::RoadObject object{.type = "roadMark", .subtype = "hatchedArea", .name = "gore"};
  object.outline = {{20.0, 3.0}, {35.0, 3.0}, {50.0, 3.0}, {50.0, 6.0}, {35.0, 4.5}, {20.0, 3.0}};
  return object;
}

TEST(RoadPaint, gores_have_lines_along_both_sides_and_strokes_over_a_third_of_them) {
  const auto pieces = road_paint(road_with(gore()));
  const Box2 box = bounds_of(pieces);
  EXPECT_NEAR(box.min_x, 20.0, 1e-9);
  EXPECT_NEAR(box.max_x, 50.0, 1e-9);
  EXPECT_NEAR(box.min_y, 3.0, 1e-9);
  EXPECT_NEAR(box.max_y, 6.0, 1e-9);
  // Lines of 0.15 m, narrower where both meet; strokes of 0.5 m every 1.5 m.
  EXPECT_NEAR(summed_m2(pieces), 2.0 * 30.0 * 0.15 + 45.0 / 3.0, 1.0);
  for (const MarkingPiece& piece : pieces)
    for (const Vec2 p : piece.corners) EXPECT_LE(p.y, 3.0 + 0.1 * (p.x - 20.0) + 1e-9) << "inside the outline";
}

TEST(RoadPaint, gores_look_the_same_whichever_way_their_outline_runs) {
  roadquery::RoadObject other = gore();
  std::reverse(other.outline.begin(), other.outline.end());
  const double area = summed_m2(road_paint(road_with(gore())));
  EXPECT_NEAR(summed_m2(road_paint(road_with(other))), area, 1e-9);
  other.outline.pop_back();
  EXPECT_TRUE(road_paint(road_with(other)).empty()) << "no two sides";
  other.outline = {{20.0, 3.0}, {35.0, 3.0}, {35.0, 3.0}, {20.0, 3.0}};
  EXPECT_TRUE(road_paint(road_with(other)).empty()) << "no width";
}

TEST(RoadPaint, stop_lines_are_solid_and_give_way_lines_are_blocks) {
  roadquery::RoadObject line{.type = "roadMark", .subtype = "signalLines", .name = "stop line"};
  line.s = 50.0, line.t = -1.5, line.length = 0.5, line.width = 3.0;
  EXPECT_NEAR(summed_m2(road_paint(road_with(line))), 1.5, 1e-9);
  line.name = "give way line";
  EXPECT_NEAR(summed_m2(road_paint(road_with(line))), 4 * 0.25, 1e-9) << "four blocks and three gaps in 2.75 m";
}

TEST(RoadPaint, arrows_fill_their_box_and_point_the_right_way) {
  roadquery::RoadObject arrow{.type = "roadMark", .subtype = "arrowStraight"};
  arrow.s = 50.0, arrow.t = -1.5, arrow.length = 5.0, arrow.width = 1.2;
  const auto at = [&](const char* subtype, double hdg) {
    arrow.subtype = subtype, arrow.hdg = hdg;
    const auto pieces = road_paint(road_with(arrow));
    EXPECT_GT(summed_m2(pieces), 0.5) << subtype;
    const Box2 box = bounds_of(pieces);
    EXPECT_GE(box.min_x, 47.5 - 1e-9);
    EXPECT_LE(box.max_x, 52.5 + 1e-9);
    EXPECT_GE(box.min_y, -2.1 - 1e-9);
    EXPECT_LE(box.max_y, -0.9 + 1e-9);
    return box;
  };
  EXPECT_NEAR(at("arrowStraight", 0.0).max_x, 52.5, 1e-9);
  EXPECT_NEAR(at("arrowStraight", std::numbers::pi).min_x, 47.5, 1e-9);
  EXPECT_NEAR(at("arrowLeft", 0.0).max_y, -0.9, 1e-9) << "to the left";
  EXPECT_NEAR(at("arrowLeft", std::numbers::pi).min_y, -2.1, 1e-9) << "whose left is the road's right";
  EXPECT_NEAR(at("arrowRight", 0.0).min_y, -2.1, 1e-9);
  const Box2 all = at("arrowStraightLeftRight", 0.0);
  EXPECT_NEAR(all.max_y - all.min_y, 1.2, 1e-9);
}

TEST(RoadPaint, the_middle_of_a_mini_roundabout_is_a_disc) {
  const roadquery::RoadObject mark{.type = "roadMark",
                                   .subtype = "paint",
                                   .name = "mini-roundabout",
                                   .s = 50.0,
                                   .t = 1.0,
                                   .length = 4.0,
                                   .width = 4.0};
  const auto pieces = road_paint(road_with(mark));
  EXPECT_NEAR(summed_m2(pieces), std::numbers::pi * 4.0, 0.2);
  const Box2 box = bounds_of(pieces);
  EXPECT_NEAR(box.min_x, 48.0, 0.05);
  EXPECT_NEAR(box.max_y, 3.0, 0.05);
}

TEST(RoadPaint, boxes_without_size_and_absurd_ones_are_passed_over) {
  roadquery::RoadObject line{.type = "roadMark", .subtype = "signalLines"};
  line.s = 50.0;
  EXPECT_TRUE(road_paint(road_with(line)).empty());
  line.length = 0.5, line.width = 1e9;
  EXPECT_TRUE(road_paint(road_with(line)).empty());
  line.type = "crosswalk", line.subtype = "zebra", line.width = 1e300;
  EXPECT_TRUE(road_paint(road_with(line)).empty());
}

}  // namespace
}  // namespace orthodrive::scene
