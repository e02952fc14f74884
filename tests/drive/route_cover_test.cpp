#include "orthodrive/drive/route_cover.hpp"

#include <gtest/gtest.h>

#include <set>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/drive/drive_all_roads.hpp"
#include "roadquery/road_query.hpp"

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
