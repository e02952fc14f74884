// SPDX-License-Identifier: Apache-2.0
// A car that keeps to its line leaves the asphalt nowhere.

#include <gtest/gtest.h>

#include <numbers>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/drive/drive_route.hpp"

namespace orthodrive {
namespace {

using namespace test;

TEST(Asphalt, a_route_that_ends_right_behind_a_bend_is_driven_on_the_road) {
  // The car still turns when the road ends: its wheels beyond the end are no reason to leave the lane.
  const double radius_m = 2.5, quarter_m = 0.5 * std::numbers::pi * radius_m, width_m = 2.2;
  Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, 60.0, Line{}}, 0.0, width_m),
       b = make_road(2, {0.0, 60.0, 0.0, 0.0, quarter_m, Arc{1.0 / radius_m}}, 0.0, width_m),
       c = make_road(3, {0.0, 60.0 + radius_m, radius_m, 0.5 * std::numbers::pi, 3.0, Line{}}, 0.0, width_m);
  link(a, b), link(b, c);
  const DriveResult lap = simulate_lap(map_of({a, b, c}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_EQ(lap.tyre_misses, 0u);
  EXPECT_GT(lap.length_m, 60.0);
}

TEST(Asphalt, a_bend_that_tightens_is_not_cut) {
  const DriveResult lap = simulate_lap(map_of(make_stadium(1, 0.0, 0.0, 80.0, 2.2)), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_LT(lap.max_line_error_m, 0.08);
}

TEST(Asphalt, a_hairpin_sharper_than_the_car_turns_is_rounded_where_there_is_room) {
  // A fork whose prongs lie 8 degrees apart, on a place of 60 m: the line through its lanes bends to 1.3 m.
  const double radius_m = 0.3, turn_rad = 3.0, way_m = 60.0;
  Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, way_m, Line{}}, 0.0, 2.0),
       b = make_road(2, {0.0, way_m, 0.0, 0.0, radius_m * turn_rad, Arc{1.0 / radius_m}}, 0.0, 2.0);
  const roadquery::PlanPoint end = roadquery::reference_point(b, b.length);
  Road c = make_road(3, {0.0, end.x, end.y, turn_rad, way_m, Line{}}, 0.0, 2.0);
  link(a, b), link(b, c);
  const Road place = make_road(4, {0.0, 0.5 * way_m, 0.0, 0.0, way_m, Line{}}, 0.0, 0.5 * way_m);
  const roadquery::RoadQuery query(map_of({a, b, c, place}));
  const DriveOptions options = family();
  const Route route{{{0, true}, {1, true}, {2, true}}, false, "hairpin", 2.0 * way_m + b.length};
  const DriveResult lap = drive_route(query, route, options, EnvelopeTable(options.car));
  EXPECT_TRUE(lap.finished);
  EXPECT_EQ(lap.tyre_misses, 0u);
}

TEST(Asphalt, a_notch_shorter_than_the_line_s_steps_is_driven_round) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 120.0, Line{}});
  auto& width = road.sections[0].right[0].width;
  width = {{.s = 0.0, .a = 3.5}, {.s = 60.38, .a = 2.2}, {.s = 60.62, .a = 3.5}};
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_EQ(lap.tyre_misses, 0u);
}

TEST(Asphalt, a_narrow_road_beside_another_one_is_driven_in_its_middle) {
  // 1.9 m wide; the road to its left touches it over the first 60 m and lies half a metre off from there on.
  const auto lanes_on_the_right = [](int id, double x, double y, double length_m, double width_m) {
    Road road = make_road(id, {0.0, x, y, 0.0, length_m, Line{}}, 0.0, width_m);
    road.sections[0].left.clear();
    return road;
  };
  const roadquery::RoadQuery query(
      map_of({lanes_on_the_right(1, 0.0, 0.0, 120.0, 1.9), lanes_on_the_right(2, 0.0, 6.0, 60.0, 6.0),
              lanes_on_the_right(3, 60.0, 6.5, 60.0, 6.0)}));
  const DriveOptions options = family();
  const DriveResult lap =
      drive_route(query, {{{0, true}}, false, "narrow", 120.0}, options, EnvelopeTable(options.car));
  EXPECT_EQ(lap.tyre_misses, 0u);
  EXPECT_NEAR(lap.length_m, 120.0, 5.0);
  for (const LinePoint& p : lap.line.points) {
    if (p.x_m > 60.0) {
      EXPECT_NEAR(p.y_m, -0.95, 0.08) << p.x_m;
    }
  }
}

}  // namespace
}  // namespace orthodrive
