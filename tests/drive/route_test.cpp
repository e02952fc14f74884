// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/routes/route.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "drive/roads.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using namespace test;
using ::testing::HasSubstr;

std::vector<int> road_ids(const RoadMap& map, const Route& route) {
  std::vector<int> ids;
  ids.reserve(route.steps.size());
  for (const RouteStep& step : route.steps)
    ids.push_back((step.forward ? 1 : -1) * map.roads[static_cast<std::size_t>(step.road)].id);
  return ids;
}

template <typename Call>
std::string option_error_of(Call&& call) {
  try {
    call();
  } catch (const OptionError& error) {
    return error.what();
  }
  return "no OptionError";
}

/// Two stadiums apart from each other: residential (ids 1-4, way 10) and raceway (ids 5-8, "Circuit").
RoadMap two_loops() {
  std::vector<Road> roads = make_stadium(1, 0.0, 0.0, 400.0, 60.0);
  for (Road& road : roads) road.highway = "residential", road.osm_id = "10";
  for (Road& road : make_stadium(5, 2000.0, 0.0, 200.0, 40.0)) {
    road.highway = "raceway", road.name = "Circuit";
    roads.push_back(road);
  }
  return map_of(roads);
}

TEST(FindRoute, auto_takes_the_raceway_first) {
  const RoadMap map = two_loops();
  const Route route = find_route(map);
  EXPECT_TRUE(route.closed);
  EXPECT_EQ(route.name, "Circuit");
  EXPECT_EQ(road_ids(map, route), (std::vector<int>{5, 6, 7, 8}));
  EXPECT_NEAR(route.length_m, 2 * 200.0 + 2 * std::numbers::pi * 40.0, 1e-9);
}

TEST(FindRoute, name_and_osm_id_choose_the_loop_and_case_does_not_matter) {
  const RoadMap map = two_loops();
  EXPECT_EQ(find_route(map, {.route = "cIRCUIT"}).name, "Circuit");
  const Route way = find_route(map, {.route = "10"});
  EXPECT_TRUE(way.closed);
  EXPECT_EQ(way.name, "way 10");
  EXPECT_EQ(road_ids(map, way), (std::vector<int>{1, 2, 3, 4}));
  EXPECT_THAT(option_error_of([&] { (void)find_route(map, {.route = "Ringvägen"}); }),
              "no road is called 'Ringvägen'; there are for example: Circuit");
  EXPECT_THAT(option_error_of([&] { (void)find_route(map, {.route = "10, 11"}); }),
              HasSubstr("no road is called '11'"));
}

TEST(FindRoute, a_lane_for_both_directions_is_driven_both_ways_and_a_bus_lane_by_no_car) {
  std::vector<Road> roads = make_stadium(1, 0.0, 0.0, 400.0, 60.0);
  for (Road& road : roads) {
    road.sections[0].left.clear();
    for (roadquery::Lane& lane : road.sections[0].right) lane.type = roadquery::LaneType::bidirectional;
  }
  const RoadMap map = map_of(roads);
  EXPECT_TRUE(is_drivable(map.roads[0], true));
  EXPECT_TRUE(is_drivable(map.roads[0], false));
  for (Road& road : roads)
    for (roadquery::Lane& lane : road.sections[0].right) lane.type = roadquery::LaneType::bus;
  EXPECT_FALSE(is_drivable(map_of(roads).roads[0], true));
}

TEST(FindRoute, lanes_give_the_direction) {
  std::vector<Road> roads = make_stadium(1, 0.0, 0.0, 400.0, 60.0);
  for (Road& road : roads) road.sections[0].right.clear();  // left lanes only: one-way against s
  const RoadMap map = map_of(roads);
  EXPECT_FALSE(is_drivable(map.roads[0], true));
  EXPECT_TRUE(is_drivable(map.roads[0], false));
  EXPECT_EQ(road_ids(map, find_route(map)), (std::vector<int>{-1, -4, -3, -2}));
  // In left-hand traffic the same lanes lead forward.
  RoadMap left = map;
  for (Road& road : left.roads) road.driving_side = roadquery::DrivingSide::left;
  EXPECT_EQ(road_ids(left, find_route(left)), (std::vector<int>{1, 2, 3, 4}));
}

/// A crossing of four arms at (0, 0); each arm ends in a junction whose connecting roads (straight or turning, ids from
/// 100) exist for the given pairs (from arm, to arm). Arms 1 east, 2 north, 3 west, 4 south begin at the junction.
/// Arms 1 and 2 are joined by a road 5 outside.
RoadMap crossing(const std::vector<std::pair<int, int>>& turns) {
  std::vector<Road> roads;
  for (int arm = 1; arm <= 4; ++arm) {
    const double hdg = 0.5 * std::numbers::pi * (arm - 1);
    roads.push_back(make_road(arm, {0.0, 20.0 * std::cos(hdg), 20.0 * std::sin(hdg), hdg, 300.0, Line{}}));
    roads.back().predecessor = {LinkKind::junction, 50, ContactPoint::start};
  }
  roads.push_back(make_road(5, {0.0, 320.0, 0.0, 0.0, 1.5 * std::numbers::pi * 320.0, Arc{1.0 / 320.0}}));
  link(roads[0], roads[4]);
  roads[4].successor = {LinkKind::road, 2, ContactPoint::end};
  roads[1].successor = {LinkKind::road, 5, ContactPoint::end};
  RoadMap map = map_of(roads);
  map.junctions = {{50, "", {}}};
  int id = 100;
  for (const auto& [from, to] : turns) {
    const auto &a = roads[static_cast<std::size_t>(from - 1)].plan[0],
               &b = roads[static_cast<std::size_t>(to - 1)].plan[0];
    const double dx = b.x - a.x, dy = b.y - a.y;
    Road connecting = make_road(id, {0.0, a.x, a.y, std::atan2(dy, dx), std::hypot(dx, dy), Line{}});
    connecting.junction = 50;
    connecting.sections[0].left.clear();
    connecting.predecessor = {LinkKind::road, from, ContactPoint::start};
    connecting.successor = {LinkKind::road, to, ContactPoint::start};
    map.roads.push_back(connecting);
    map.junctions[0].connections.push_back({id, from, id, ContactPoint::start, {{1, -1}}});
    ++id;
  }
  return map;
}

TEST(FindRoute, goes_through_junctions_only_where_connections_lead) {
  const RoadMap map = crossing({{2, 1}});  // from the north arm into the east arm
  const Route loop = find_route(map);
  EXPECT_TRUE(loop.closed);
  EXPECT_EQ(road_ids(map, loop), (std::vector<int>{5, -2, 100, 1}));
  // Without that connection there is no loop in this sense; the other sense needs one from 1 into 2.
  EXPECT_FALSE(find_route(crossing({{1, 3}, {2, 4}})).closed);
  const RoadMap other = crossing({{1, 2}});
  EXPECT_EQ(road_ids(other, find_route(other)), (std::vector<int>{-5, -1, 100, 2}));
  // The lane link starts in a lane of the other direction: nobody can come from there.
  RoadMap wrong = crossing({{2, 1}});
  wrong.junctions[0].connections[0].lane_links = {{-1, -1}};
  EXPECT_FALSE(find_route(wrong).closed);
}

TEST(FindRoute, link_between_ends_far_apart_is_no_way) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}});
  link(road, road);  // says it closes, but its end is 100 m from its start
  EXPECT_FALSE(find_route(map_of({road})).closed);
}

TEST(FindRoute, open_route_is_the_longest_way) {
  const RoadMap map = crossing({{3, 1}, {3, 4}});
  const Route route = find_route(map);
  EXPECT_FALSE(route.closed);
  EXPECT_EQ(road_ids(map, route), (std::vector<int>{-3, 100, 1, 5, -2}));
}

TEST(FindRoute, via_points_are_passed_in_order) {
  const RoadMap map = crossing({{2, 1}, {1, 2}, {3, 1}, {2, 3}, {1, 4}});
  const Route one_way = find_route(map, {.via = {{150.0, 3.0}, {0.0, 200.0}}});
  EXPECT_TRUE(one_way.closed);
  EXPECT_EQ(road_ids(map, one_way).size(), 4u);
  EXPECT_EQ(std::abs(road_ids(map, one_way)[0]), 1);
  EXPECT_THAT(option_error_of([&] {
                (void)find_route(map, {.via = {{150.0, 0.0}, {5000.0, 0.0}}});
              }),
              HasSubstr("--via 5000.0,0.0: the nearest road is"));
  EXPECT_THAT(option_error_of([&] {
                (void)find_route(map, {.via = {{0.0, -200.0}, {150.0, 0.0}}});
              }),
              HasSubstr("--via"));
}

TEST(FindRoute, no_driving_lane_anywhere_is_an_error) {
  Road path = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}});
  path.sections[0].left[0].type = path.sections[0].right[0].type = roadquery::LaneType::sidewalk;
  EXPECT_THROW((void)find_route(map_of({path})), Error);
  EXPECT_THROW((void)find_route(RoadMap{}), Error);
}

}  // namespace
}  // namespace orthodrive
