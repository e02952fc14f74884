// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/routes/route_cover.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/drive/drive_all_roads.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace test;

/// A stadium driven both ways, and a road apart from it.
RoadMap network() {
  std::vector<Road> roads = make_stadium(1, 0.0, 0.0, 120.0, 25.0);
  roads.push_back(make_road(9, {0.0, 900.0, 0.0, 0.0, 50.0, Line{}}));
  for (Road& road : roads) road.speed_limit_mps = 50.0 / 3.6;
  return map_of(roads);
}

TEST(RoutesOverAllRoads, every_direction_of_the_largest_part_is_driven_and_nothing_else) {
  const RoadMap map = network();
  std::set<std::pair<int, bool>> seen;
  for (const Route& route : routes_over_all_roads(map)) {
    EXPECT_FALSE(route.closed);
    for (const RouteStep& step : route.steps)
      seen.insert({map.roads[static_cast<std::size_t>(step.road)].id, step.forward});
  }
  EXPECT_EQ(seen.size(), 8u);
  for (int id = 1; id <= 4; ++id)
    for (const bool forward : {false, true}) EXPECT_TRUE(seen.contains({id, forward})) << id << forward;
  EXPECT_TRUE(routes_over_all_roads(RoadMap{}).empty());
}

/// Three arms of 20 m at a junction of connecting roads, each arm 9 m from its middle; a car length of road lies
/// between the southern arm and a further road.
RoadMap junction_of_three() {
  const double pi = std::numbers::pi;
  std::vector<Road> roads;
  const std::array<double, 3> towards = {0.0, pi, -0.5 * pi};
  for (int arm = 0; arm < 3; ++arm) {
    const double hdg = towards[static_cast<std::size_t>(arm)];
    roads.push_back(
        make_road(arm + 1, {0.0, 9.0 * std::cos(hdg), 9.0 * std::sin(hdg), hdg, arm == 2 ? 4.0 : 20.0, Line{}}));
    roads.back().predecessor = {LinkKind::junction, 50, ContactPoint::start};
  }
  roads.push_back(make_road(4, {0.0, 0.0, -13.0, -0.5 * pi, 30.0, Line{}}));
  link(roads[2], roads[3]);
  RoadMap map = map_of(roads);
  map.junctions = {{50, "", {}}};
  int id = 100;
  const auto turn = [&](int from, int to, double hdg, double length_m, double curvature_1pm) {
    const auto& a = roads[static_cast<std::size_t>(from - 1)].plan[0];
    Road road = curvature_1pm == 0.0 ? make_road(id, {0.0, a.x, a.y, hdg, length_m, Line{}})
                                     : make_road(id, {0.0, a.x, a.y, hdg, length_m, Arc{curvature_1pm}});
    road.junction = 50;
    road.sections[0].left.clear();
    road.predecessor = {LinkKind::road, from, ContactPoint::start};
    road.successor = {LinkKind::road, to, ContactPoint::start};
    map.roads.push_back(road);
    map.junctions[0].connections.push_back({id, from, id, ContactPoint::start, {{1, -1}}});
    ++id;
  };
  const double quarter_m = 4.5 * pi;
  turn(1, 2, pi, 18.0, 0.0), turn(2, 1, 0.0, 18.0, 0.0);
  turn(1, 3, pi, quarter_m, 1.0 / 9.0), turn(3, 1, 0.5 * pi, quarter_m, -1.0 / 9.0);
  turn(2, 3, 0.0, quarter_m, -1.0 / 9.0), turn(3, 2, 0.5 * pi, quarter_m, 1.0 / 9.0);
  return map;
}

TEST(RoutesOverAllRoads, routes_begin_and_end_with_room_to_stand_straight) {
  const RoadMap map = junction_of_three();
  const std::vector<Route> routes = routes_over_all_roads(map);
  std::set<int> turns;
  for (const Route& route : routes) {
    const auto road = [&](const RouteStep& step) -> const Road& {
      return map.roads[static_cast<std::size_t>(step.road)];
    };
    EXPECT_LT(road(route.steps.front()).junction, 0) << route.name;
    EXPECT_LT(road(route.steps.back()).junction, 0) << route.name;
    // Never the short road alone: it is no longer than the car.
    EXPECT_NE(road(route.steps.front()).id, 3) << route.name;
    EXPECT_NE(road(route.steps.back()).id, 3) << route.name;
    for (const RouteStep& step : route.steps)
      if (road(step).junction >= 0) turns.insert(road(step).id);
  }
  EXPECT_EQ(turns.size(), 6u);
  const AllRoadsResult all = drive_all_roads(map, family());
  EXPECT_EQ(all.tyre_misses, 0u);
  EXPECT_EQ(all.finished, all.routes);
}

TEST(DriveAllRoads, goes_on_behind_a_bend_that_is_too_tight_for_the_car) {
  // A stadium whose half circles have a radius of 1 m: nothing but the straights is left to drive.
  std::vector<Road> roads = make_stadium(1, 0.0, 0.0, 80.0, 1.0);
  for (Road& road : roads) road.speed_limit_mps = 50.0 / 3.6;
  const AllRoadsResult all = drive_all_roads(map_of(roads), family(), 2);
  EXPECT_GT(all.too_tight_places, 0);
  EXPECT_EQ(all.off_road_places, 0);
  EXPECT_EQ(all.tyre_misses, 0u);
  EXPECT_GT(all.length_m, 200.0);
}

TEST(DriveAllRoads, lane_on_the_inside_may_be_shorter_than_the_shortest_route) {
  // The road is 14 m long, its left lane 14 (12 - 8) / 12 = 4.7 m: nothing to drive on, and no reason to stop.
  const AllRoadsResult all =
      drive_all_roads(map_of({make_road(1, {0.0, 0.0, 0.0, 0.0, 14.0, Arc{1.0 / 12.0}}, 0.0, 16.0)}), family(), 1);
  EXPECT_EQ(all.routes, 2);
  EXPECT_EQ(all.too_short, 1);
  EXPECT_EQ(all.finished, 1);
  ASSERT_EQ(all.findings.size(), 1u);
  EXPECT_EQ(all.findings[0].code, "drive.too_short");
}

TEST(DriveAllRoads, good_roads_give_no_finding_and_threads_change_nothing) {
  const RoadMap map = network();
  const AllRoadsResult one = drive_all_roads(map, family(), 1), two = drive_all_roads(map, family(), 2);
  EXPECT_EQ(one.finished, one.routes);
  EXPECT_TRUE(one.findings.empty()) << one.findings.front().message;
  EXPECT_EQ(one.tyre_misses, 0u);
  EXPECT_LT(one.max_vertical_mps2, 2.0);
  EXPECT_EQ(one.tyre_queries, two.tyre_queries);
  EXPECT_EQ(one.max_vertical_mps2, two.max_vertical_mps2);
  EXPECT_EQ(one.max_line_error_m, two.max_line_error_m);
}

TEST(DriveAllRoads, a_step_and_a_hump_are_found_where_they_are) {
  RoadMap map = network();
  map.roads[0].elevation = {{0.0, 0.0, 0.0, 0.0, 0.0}, {60.0, 0.08, 0.0, 0.0, 0.0}, {70.0, 0.0, 0.0, 0.0, 0.0}};
  const AllRoadsResult all = drive_all_roads(map, family(), 2);
  EXPECT_GT(all.bump_places, 0);
  EXPECT_GT(all.jolt_places, 0);
  EXPECT_NEAR(all.max_height_step_m, 0.08, 1e-3);
  for (const Finding& f : all.findings) EXPECT_NEAR(f.x_m, 65.0, 12.0) << f.code;
}

}  // namespace
}  // namespace orthodrive
