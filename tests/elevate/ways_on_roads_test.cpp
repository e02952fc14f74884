// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/ways_on_roads.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "test_roads.hpp"

namespace orthodrive::elevate {
namespace {

using test::straight_road;

/// A block of 100 m x 60 m: paths 0 (south) and 1 (east) lead round one corner, 2 (west) and 3 (north) round the other.
RoadNetwork block() {
  return {test::road_crs,
          {straight_road(1, {0, 0}, {100, 0}, 1, 2), straight_road(2, {100, 0}, {100, 60}, 2, 3),
           straight_road(3, {0, 0}, {0, 60}, 1, 4), straight_road(4, {0, 60}, {100, 60}, 4, 3)}};
}

double way_m(const WaysOnRoads& ways, const DirectedPlace& from, const DirectedPlace& to, double limit_m = 500.0) {
  return ways.way_m(from, to, ways.reach_from(from, limit_m));
}

TEST(WaysOnRoads, take_the_shorter_way_round_a_block) {
  const RoadNetwork roads = block();
  const WaysOnRoads ways(roads);
  const DirectedPlace south{.path = 0, .s_m = 30.0, .forward = true}, north{.path = 3, .s_m = 80.0, .forward = false};
  EXPECT_NEAR(way_m(ways, south, north), 70.0 + 60.0 + 20.0, 1e-9);
  const DirectedPlace back{.path = 0, .s_m = 30.0, .forward = false}, on{.path = 3, .s_m = 80.0, .forward = true};
  EXPECT_NEAR(way_m(ways, back, on), 30.0 + 60.0 + 80.0, 1e-9);
  const auto stretches = ways.stretches(south, north, ways.reach_from(south, 500.0));
  ASSERT_EQ(stretches.size(), 3U);
  EXPECT_EQ(stretches[0].path, 0U);
  EXPECT_EQ(stretches[1].path, 1U);
  EXPECT_EQ(stretches[2].path, 3U);
  EXPECT_EQ(stretches[2].s_from, 100.0);
  EXPECT_EQ(stretches[2].s_to, 80.0) << "against its direction";
}

TEST(WaysOnRoads, straight_on_along_one_road_and_a_little_backwards) {
  const RoadNetwork roads = block();
  const WaysOnRoads ways(roads);
  const DirectedPlace from{.path = 0, .s_m = 30.0, .forward = true};
  EXPECT_NEAR(way_m(ways, from, {.path = 0, .s_m = 55.0, .forward = true}), 25.0, 1e-9);
  EXPECT_NEAR(way_m(ways, from, {.path = 0, .s_m = 27.0, .forward = true}), 3.0, 1e-9) << "noise of positions";
  EXPECT_NEAR(way_m(ways, from, {.path = 0, .s_m = 20.0, .forward = true}), 70 + 60 + 100 + 60 + 20, 1e-9)
      << "10 m back is a drive round the block";
}

TEST(WaysOnRoads, turn_on_the_spot_at_the_last_node_only_and_never_drive_against_a_one_way_road) {
  RoadNetwork roads = block();
  const DirectedPlace from{.path = 0, .s_m = 30.0, .forward = true}, back{.path = 0, .s_m = 30.0, .forward = false};
  EXPECT_NEAR(way_m(WaysOnRoads(roads), from, back), 70.0 + 70.0, 1e-9) << "to the end of the road and back";
  const WaysOnRoads::Reach reach = WaysOnRoads(roads).reach_from(from, 150.0);
  EXPECT_THAT(reach, testing::SizeIs(2)) << "vertices 2 and 3: nothing goes on back along path 0";
  roads.paths[3].oneway = Oneway::forward;
  EXPECT_NEAR(way_m(WaysOnRoads(roads), from, {.path = 1, .s_m = 30.0, .forward = true}), 100.0, 1e-9);
  const WaysOnRoads ways(roads);
  EXPECT_THAT(ways.reach_from({.path = 1, .s_m = 30.0, .forward = true}, 500.0), testing::SizeIs(1))
      << "the end of path 1, from where path 3 must not be driven back";
}

TEST(WaysOnRoads, reach_ends_at_the_limit) {
  const RoadNetwork roads = block();
  const WaysOnRoads ways(roads);
  const DirectedPlace from{.path = 0, .s_m = 30.0, .forward = true}, to{.path = 1, .s_m = 10.0, .forward = true};
  EXPECT_NEAR(way_m(ways, from, to, 71.0), 80.0, 1e-9);
  EXPECT_TRUE(std::isinf(way_m(ways, from, to, 69.0)));
}

}  // namespace
}  // namespace orthodrive::elevate
