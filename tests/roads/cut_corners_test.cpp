// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/cut_corners.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace orthodrive {
namespace {

struct Place {
  Vec2 p;
  std::int64_t id = 0;
};

RoadPath way(std::int64_t id, const std::vector<Place>& places) {
  RoadPath path;
  path.osm_id = id, path.highway = "residential";
  for (const Place& place : places)
    path.nodes.push_back(
        {.p = place.p,
         .osm_node = place.id,
         .s_m = path.nodes.empty() ? 0.0 : path.nodes.back().s_m + distance(path.nodes.back().p, place.p),
         .width_m = 5.0});
  return path;
}

RoadNetwork network(std::vector<RoadPath> paths) { return {.crs = Crs{"EPSG:32633"}, .paths = std::move(paths)}; }

/// From the west to the node 2 and off to the north; way 9 goes on to the east from there.
RoadNetwork corner() {
  return network({way(7, {{{-40, 0}, 1}, {{0, 0}, 2}, {{0, 40}, 3}}), way(9, {{{0, 0}, 2}, {{40, 5}, 4}})});
}

TEST(CutCorners, way_that_turns_off_where_another_runs_straight_on_is_two_roads) {
  RoadNetwork roads = corner();
  cut_at_corners(roads);
  ASSERT_EQ(roads.paths.size(), 3u);
  EXPECT_EQ(roads.paths[0].osm_id, 7);
  EXPECT_EQ(roads.paths[1].osm_id, 7);
  EXPECT_EQ(roads.paths[0].part, 0);
  EXPECT_EQ(roads.paths[1].part, 1);
  EXPECT_EQ(roads.paths[0].nodes.back().osm_node, 2);
  EXPECT_EQ(roads.paths[1].nodes.front().osm_node, 2);
  EXPECT_DOUBLE_EQ(roads.paths[1].nodes.front().s_m, 0.0);
  EXPECT_DOUBLE_EQ(roads.paths[1].nodes.back().s_m, 40.0);
  EXPECT_EQ(roads.paths[2].osm_id, 9);
  EXPECT_EQ(roads.paths[2].part, 0);
}

TEST(CutCorners, also_where_the_other_way_passes) {
  RoadNetwork roads = network({way(7, {{{-40, 0}, 1}, {{0, 0}, 2}, {{0, 40}, 3}}),
                               way(9, {{{0, -40}, 5}, {{0, 0}, 2}, {{40, 5}, 4}})});  // two Ls that make a crossing
  cut_at_corners(roads);
  EXPECT_EQ(roads.paths.size(), 4u);
}

TEST(CutCorners, bend_of_a_road_stays_whole) {
  RoadNetwork alone = network({way(7, {{{-40, 0}, 1}, {{0, 0}, 2}, {{0, 40}, 3}})});
  cut_at_corners(alone);
  EXPECT_EQ(alone.paths.size(), 1u) << "nobody else is there";
  RoadNetwork outside = network(
      {way(7, {{{-40, 0}, 1}, {{0, 0}, 2}, {{0, 40}, 3}}), way(9, {{{0, 0}, 2}, {{-20, 20}, 4}})});  // inside the bend
  cut_at_corners(outside);
  EXPECT_EQ(outside.paths.size(), 2u) << "the other one continues neither arm";
  RoadNetwork gentle =
      network({way(7, {{{-40, 0}, 1}, {{0, 0}, 2}, {{30, 26}, 3}}), way(9, {{{0, 0}, 2}, {{40, 0}, 4}})});
  cut_at_corners(gentle);
  EXPECT_EQ(gentle.paths.size(), 2u) << "41 degrees";
}

TEST(CutCorners, rings_stay_whole) {
  RoadNetwork roads = corner();
  roads.paths[0].roundabout = true;
  cut_at_corners(roads);
  EXPECT_EQ(roads.paths.size(), 2u);
}

TEST(CutCorners, parts_of_a_way_are_counted_on_and_nothing_is_lost) {
  RoadNetwork roads = corner();
  RoadPath later = way(7, {{{0, 80}, 0}, {{0, 120}, 6}});  // the way comes back into the area
  later.part = 1;
  roads.paths.insert(roads.paths.begin() + 1, later);
  double before_m = 0.0, after_m = 0.0;
  for (const RoadPath& path : roads.paths) before_m += path.nodes.back().s_m;
  cut_at_corners(roads);
  ASSERT_EQ(roads.paths.size(), 4u);
  for (const RoadPath& path : roads.paths) after_m += path.nodes.back().s_m;
  EXPECT_DOUBLE_EQ(before_m, after_m);
  EXPECT_EQ(roads.paths[2].part, 2);
  const std::size_t count = roads.paths.size();
  cut_at_corners(roads);
  EXPECT_EQ(roads.paths.size(), count) << "twice is once";
}

}  // namespace
}  // namespace orthodrive
