// SPDX-License-Identifier: Apache-2.0
// Roads whose cross section is not a plane: <shape> of the lateral profile.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

using test::make_road;

/// A roof: both halves fall by `fall` away from the reference line.
std::vector<ShapeCubic> roof(double s, double fall) {
  return {{.s = s, .t = -10.0, .a = -10.0 * fall, .b = fall}, {.s = s, .t = 0.0, .a = 0.0, .b = -fall}};
}
void append(Road& road, const std::vector<ShapeCubic>& shapes) {
  road.shape.insert(road.shape.end(), shapes.begin(), shapes.end());
}

Road curved_road() {
  Road road = make_road(1, {0.0, 100.0, 200.0, 0.4, 60.0, Spiral{0.002, 0.02}}, 30.0);
  road.elevation = {{.s = 0.0, .a = 30.0, .b = 0.03, .c = -4e-4}};
  road.superelevation = {{.s = 0.0, .a = 0.04, .b = 1e-3, .c = -1e-5}};
  append(road, roof(0.0, 0.025));
  append(road, {{.s = 30.0, .t = -4.0, .a = -0.02, .b = 0.004, .c = 2e-4, .d = -1e-5},
                {.s = 30.0, .t = -1.0, .a = 0.01, .b = -0.01},
                {.s = 30.0, .t = 2.0, .a = -0.03, .b = -0.02, .c = -1e-3}});
  append(road, roof(45.0, 0.0));
  return road;
}

TEST(Shape, roof_falls_to_both_sides) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 50.0, Line{}}, 7.0);
  append(road, roof(0.0, 0.025));
  for (const double s : {0.0, 12.0, 50.0}) {
    EXPECT_NEAR(surface_point(road, s, 0.0).z, 7.0, 1e-15);
    EXPECT_NEAR(surface_point(road, s, 3.0).z, 7.0 - 0.075, 1e-14);
    EXPECT_NEAR(surface_point(road, s, -3.0).z, 7.0 - 0.075, 1e-14);
    EXPECT_NEAR(surface_point(road, s, -12.0).z, 7.0 - 0.3, 1e-14) << "the first cubic goes on to the right";
    EXPECT_NEAR(surface_point(road, s, 3.0).normal[1], std::sin(std::atan(0.025)), 1e-14);
    EXPECT_NEAR(surface_point(road, s, -3.0).normal[1], -std::sin(std::atan(0.025)), 1e-14);
  }
}

TEST(Shape, each_half_of_a_banked_roof_is_turned_by_banking_and_fall) {
  const double bank = 0.05, fall = 0.025;
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 50.0, Line{}}, 0.0);
  road.superelevation = {{.s = 0.0, .a = bank}};
  append(road, roof(0.0, fall));
  const SurfacePoint left = surface_point(road, 10.0, 4.0), right = surface_point(road, 10.0, -4.0);
  EXPECT_NEAR(std::atan2(left.z, left.y), bank - std::atan(fall), 1e-14);
  EXPECT_NEAR(std::atan2(-right.z, -right.y), bank + std::atan(fall), 1e-14);
  EXPECT_NEAR(std::hypot(left.y, left.z), 4.0 * std::hypot(1.0, fall), 1e-14);
}

TEST(Shape, is_linear_in_s_between_shapes_and_zero_before_the_first) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 50.0, Line{}}, 0.0);
  append(road, roof(10.0, 0.02));
  append(road, roof(30.0, 0.04));
  EXPECT_EQ(shape(road, 9.999, 2.0).h, 0.0);
  EXPECT_NEAR(shape(road, 10.0, 2.0).h, -0.04, 1e-15);
  EXPECT_NEAR(shape(road, 25.0, 2.0).h, -0.07, 1e-15);
  EXPECT_NEAR(shape(road, 25.0, 2.0).dh_ds, -0.002, 1e-15);
  EXPECT_NEAR(shape(road, 25.0, 2.0).dh_dt, -0.035, 1e-15);
  EXPECT_NEAR(shape(road, 50.0, -2.0).h, -0.08, 1e-15) << "holds after the last";
  EXPECT_EQ(shape(road, 50.0, -2.0).dh_ds, 0.0);
}

TEST(Shape, normal_is_at_right_angles_to_the_surface) {
  const Road road = curved_road();
  const double h = 1e-5;
  for (const double s : {3.0, 15.0, 31.0, 44.0, 52.0})
    for (const double t : {-4.5, -3.0, -0.5, 0.5, 1.9, 3.5}) {
      const SurfacePoint p = surface_point(road, s, t);
      const SurfacePoint s0 = surface_point(road, s - h, t), s1 = surface_point(road, s + h, t);
      const SurfacePoint t0 = surface_point(road, s, t - h), t1 = surface_point(road, s, t + h);
      const auto along = [&](const SurfacePoint& a, const SurfacePoint& b) {
        return ((b.x - a.x) * p.normal[0] + (b.y - a.y) * p.normal[1] + (b.z - a.z) * p.normal[2]) / (2.0 * h);
      };
      EXPECT_NEAR(along(s0, s1), 0.0, 1e-8) << s << " " << t;
      EXPECT_NEAR(along(t0, t1), 0.0, 1e-8) << s << " " << t;
      EXPECT_NEAR(std::hypot(p.normal[0], p.normal[1], p.normal[2]), 1.0, 1e-14);
    }
}

TEST(Shape, query_finds_the_surface_above_a_place) {
  const Road road = curved_road();
  RoadMap map;
  map.roads = {road};
  const RoadQuery query(map);
  Cursor cursor;
  for (double s = 1.0; s < 59.0; s += 2.3)
    for (const double t : {-3.4, -1.3, 0.0, 0.8, 3.4}) {
      const SurfacePoint p = surface_point(road, s, t);
      const auto hit = query.find(p.x, p.y, p.z, cursor);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->s, s, 1e-6);
      EXPECT_NEAR(hit->t, t, 1e-8);
      EXPECT_NEAR(hit->z, p.z, 1e-7);
      EXPECT_NEAR(surface_height(road, s, t), p.z, 1e-13);
    }
}

std::string shaped_file(const std::string& lateral, const std::string& surface) {
  return "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/><road id=\"1\" length=\"10\" junction=\"-1\"><planView>"
         "<geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"10\"><line/></geometry></planView><lateralProfile>" +
         lateral +
         "</lateralProfile><lanes><laneSection s=\"0\"><center><lane id=\"0\"/></center></laneSection></lanes>" +
         surface + "</road></OpenDRIVE>";
}
std::string written(const std::string& text) {
  const std::string path = ::testing::TempDir() + "shape_test.xodr";
  std::ofstream(path) << text;
  return path;
}

TEST(Shape, is_read_with_the_reference_to_a_crg_file) {
  const RoadMap map = read_opendrive(written(shaped_file(
      "<superelevation s=\"0\" a=\"0.1\" b=\"0\" c=\"0\" d=\"0\"/>"
      "<shape s=\"0\" t=\"-3\" a=\"1\" b=\"2\" c=\"3\" d=\"4\"/><shape s=\"0\" t=\"0\" a=\"5\" b=\"0\" c=\"0\" "
      "d=\"0\"/>"
      "<shape s=\"4\" t=\"-3\" a=\"6\" b=\"0\" c=\"0\" d=\"0\"/>",
      "<surface><CRG file=\"a.crg\" sStart=\"1\" sEnd=\"9\" orientation=\"opposite\" mode=\"attached\" tOffset=\"0.5\" "
      "zScale=\"2\"/></surface>")));
  const Road& road = map.roads.at(0);
  ASSERT_EQ(road.shape.size(), 3u);
  EXPECT_EQ(road.shape[0].t, -3.0);
  EXPECT_EQ(road.shape[0].d, 4.0);
  EXPECT_EQ(road.shape[2].s, 4.0);
  ASSERT_EQ(road.surface.size(), 1u);
  EXPECT_EQ(road.surface[0].file, "a.crg");
  EXPECT_EQ(road.surface[0].s_end, 9.0);
  EXPECT_EQ(road.surface[0].mode, "attached");
  EXPECT_EQ(road.surface[0].orientation, "opposite");
  EXPECT_EQ(road.surface[0].purpose, "elevation");
  EXPECT_EQ(road.surface[0].t_offset, 0.5);
  EXPECT_EQ(road.surface[0].z_scale, 2.0);
}

TEST(Shape, out_of_order_is_sorted_and_the_last_one_of_a_place_counts) {
  const std::string one = "<shape s=\"1\" t=\"2\" a=\"0\" b=\"0\" c=\"0\" d=\"0\"/>";
  const RoadMap sorted =
      read_opendrive(written(shaped_file(one + "<shape s=\"0\" t=\"3\" a=\"0\" b=\"0\" c=\"0\" d=\"0\"/>", "")));
  ASSERT_EQ(sorted.roads[0].shape.size(), 2u);
  EXPECT_EQ(sorted.roads[0].shape[0].t, 3.0);
  const RoadMap repeated =
      read_opendrive(written(shaped_file(one + "<shape s=\"1\" t=\"2\" a=\"5\" b=\"0\" c=\"0\" d=\"0\"/>", "")));
  ASSERT_EQ(repeated.roads[0].shape.size(), 1u);
  EXPECT_EQ(repeated.roads[0].shape[0].a, 5.0);
}

}  // namespace
}  // namespace roadquery
