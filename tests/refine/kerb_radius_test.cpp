// SPDX-License-Identifier: Apache-2.0
// Corners of known radius painted into labels.

#include "orthodrive/refine/kerb_radius.hpp"

#include <gtest/gtest.h>

#include <array>

#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace test;

constexpr double size_m = 120.0;
const Vec2 corner_at = at(60.0, 60.0);

RoadPath way(std::int64_t id, Vec2 from, Vec2 to, double width_m, std::int64_t at_middle) {
  RoadPath path{.osm_id = id, .highway = "residential"};
  const double whole = distance(from, to);
  for (double s = 0.0; s <= whole + 1e-9; s += 2.0) {
    const Vec2 p = from + (to - from) * (s / whole);
    path.nodes.push_back(
        {.p = p, .osm_node = distance(p, corner_at) < 1e-6 ? at_middle : 0, .s_m = s, .width_m = width_m});
  }
  return path;
}

Vec2 towards(double angle, double far = 50.0) { return corner_at + Vec2{std::cos(angle), std::sin(angle)} * far; }

/// Whether a kerb of that radius paves `p` between the edges of two roads that leave at the angles a < b.
bool is_paved(Vec2 p, double a, double b, double width_m, double radius_m) {
  const Vec2 u{std::cos(a), std::sin(a)}, v{std::cos(b), std::sin(b)};
  // Distances from the edges; the arc's centre has the radius as both.
  const double from_a = cross(u, p - corner_at) - 0.5 * width_m, from_b = cross(p - corner_at, v) - 0.5 * width_m;
  if (from_a < 0.0 || from_b < 0.0) return false;
  const double sine = std::sin(b - a), off = 0.5 * width_m + radius_m;
  const Vec2 center = corner_at + (u + v) * (off / sine);
  const Vec2 touch_a = center - left_normal(u) * radius_m, touch_b = center + left_normal(v) * radius_m;
  const bool before_chord = cross(touch_b - touch_a, p - touch_a) > 0.0;
  return before_chord && distance(p, center) >= radius_m;
}

/// Four arms; the second way leaves at `angle`. Corners have these radii, from the first counter-clockwise.
RoadScene crossing(double angle, const std::array<double, 4>& radii_m, double width_m = 7.0) {
  RoadScene scene = make_scene(size_m, 0.25);
  const std::array<double, 5> angles{0.0, angle, M_PI, M_PI + angle, 2.0 * M_PI};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec2 from = towards(angles[i + 2]), to = towards(angles[i]);
    add_truth(scene, straight(from, to), width_m);
    scene.osm.paths.push_back(way(static_cast<std::int64_t>(i) + 1, from, to, width_m, 7));
  }
  for (int r = 0; r < scene.labels.frame.height; ++r)
    for (int c = 0; c < scene.labels.frame.width; ++c)
      for (std::size_t i = 0; i < 4; ++i)
        if (is_paved(scene.labels.frame.center_of(c, r), angles[i], angles[i + 1], width_m, radii_m[i]))
          scene.labels.labels.at(c, r) = label_road;
  return scene;
}

double measured(RoadScene& scene) {
  const int junctions = measure_kerb_radii(scene.osm, scene.labels);
  const RoadNode& node = scene.osm.paths[0].nodes[25];
  EXPECT_EQ(node.osm_node, 7);
  EXPECT_EQ(junctions, node.kerb_radius_m > 0.0 ? 1 : 0);
  EXPECT_EQ(node.kerb_radius_m, scene.osm.paths[1].nodes[25].kerb_radius_m);
  EXPECT_EQ(scene.osm.paths[0].nodes[24].kerb_radius_m, 0.0);
  return node.kerb_radius_m;
}

TEST(KerbRadius, is_that_of_the_paint_at_every_angle) {
  for (const double angle : {M_PI / 2, 1.2, 1.9})
    for (const double radius : {3.0, 5.0, 8.0, 11.0}) {
      RoadScene scene = crossing(angle, {radius, radius, radius, radius});
      EXPECT_NEAR(measured(scene), radius, 0.35) << "angle " << angle;
    }
}

TEST(KerbRadius, is_the_median_of_the_corners) {
  RoadScene scene = crossing(M_PI / 2, {4.0, 6.0, 6.0, 10.0});
  EXPECT_NEAR(measured(scene), 6.0, 0.35);
}

TEST(KerbRadius, of_sharp_corners_is_small) {
  RoadScene scene = crossing(M_PI / 2, {0.0, 0.0, 0.0, 0.0});
  EXPECT_GT(measured(scene), 0.0);
  EXPECT_LT(measured(scene), 1.5);
}

TEST(KerbRadius, trees_hide_corners_and_squares_have_none) {
  RoadScene scene = crossing(M_PI / 2, {5.0, 5.0, 5.0, 5.0});
  for (const Vec2 sign : {Vec2{1, 1}, {-1, 1}, {-1, -1}})  // three of four
    paint_disc(scene.labels, corner_at + sign * 8.0, 7.0, label_vegetation);
  EXPECT_NEAR(measured(scene), 5.0, 0.35);
  paint_disc(scene.labels, corner_at + Vec2{8.0, -8.0}, 7.0, label_vegetation);
  EXPECT_EQ(measured(scene), 0.0);
  RoadScene square = crossing(M_PI / 2, {5.0, 5.0, 5.0, 5.0});
  paint_disc(square.labels, corner_at, 40.0, label_road);
  EXPECT_EQ(measured(square), 0.0);
}

TEST(KerbRadius, roads_that_the_labels_miss_have_no_corners) {
  RoadScene scene = crossing(M_PI / 2, {5.0, 5.0, 5.0, 5.0});
  paint(scene.labels, {at(0, 65), at(120, 65), at(120, 120), at(0, 120)},
        label_grass);  // north of the way from west to east
  EXPECT_NEAR(measured(scene), 5.0, 0.35) << "southern corners";
  paint(scene.labels, {at(0, 0), at(120, 0), at(120, 55), at(0, 55)}, label_grass);
  EXPECT_EQ(measured(scene), 0.0);
}

TEST(KerbRadius, specks_do_not_move_it) {
  RoadScene scene = crossing(M_PI / 2, {6.0, 6.0, 6.0, 6.0});
  std::uint32_t state = 1;
  for (std::uint8_t& label : scene.labels.labels.data) {
    state = state * 1664525u + 1013904223u;
    if (state >> 28 == 0) label = label == label_road ? label_grass : label_road;  // one of sixteen
  }
  EXPECT_NEAR(measured(scene), 6.0, 0.7);
}

TEST(KerbRadius, needs_three_arms_and_room_for_them) {
  RoadScene scene = make_scene(size_m, 0.25);
  const Vec2 from = towards(M_PI), to = towards(0.0);
  scene.osm.paths = {way(1, from, to, 7.0, 7), way(2, corner_at, corner_at + Vec2{0.0, 6.0}, 7.0, 7)};
  EXPECT_EQ(measure_kerb_radii(scene.osm, scene.labels), 0);
  scene.osm.paths.clear();
  EXPECT_EQ(measure_kerb_radii(scene.osm, scene.labels), 0);
}

}  // namespace
}  // namespace orthodrive
