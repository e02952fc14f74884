// SPDX-License-Identifier: Apache-2.0
// Roads that the map draws more than once along the same nodes (docs/notes/trackers.md has the reports).
#include "orthodrive/roads/drawn_twice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

using ::testing::ElementsAre;

/// Nodes 1, 2, 3, ... lie 100 m apart along x, and 10 beside the second.
RoadPath way_over(std::int64_t way, const std::vector<std::int64_t>& nodes,
                  const std::string& highway = "residential") {
  RoadPath path{.osm_id = way, .highway = highway};
  for (const std::int64_t id : nodes) {
    const Vec2 p = id == 10 ? Vec2{200, 80} : Vec2{100.0 * static_cast<double>(id), 0};
    const double s_m = path.nodes.empty() ? 0.0 : path.nodes.back().s_m + distance(path.nodes.back().p, p);
    path.nodes.push_back({.p = p, .osm_node = id, .s_m = s_m, .width_m = 5.0});
  }
  return path;
}

std::vector<std::string> drawn(const RoadNetwork& roads) {
  std::vector<std::string> all;
  for (const RoadPath& path : roads.paths) {
    std::string text = std::to_string(path.osm_id) + "/" + std::to_string(path.part) + ":";
    for (const RoadNode& node : path.nodes) text += " " + std::to_string(node.osm_node);
    all.push_back(text);
    EXPECT_EQ(path.nodes.front().s_m, 0.0);
    EXPECT_GT(path.nodes.back().s_m, 0.0);
  }
  return all;
}

std::size_t draw(RoadNetwork& roads) {
  Findings findings;
  draw_once(roads, findings);
  for (const Finding& finding : findings) EXPECT_EQ(finding.code, "osm.drawn_twice");
  return findings.size();
}

TEST(DrawOnce, roads_that_meet_stay_as_they_are) {
  RoadNetwork roads{{}, {way_over(1, {1, 2, 3}), way_over(2, {2, 10}), way_over(3, {3, 4})}};
  EXPECT_EQ(draw(roads), 0U);
  EXPECT_THAT(drawn(roads), ElementsAre("1/0: 1 2 3", "2/0: 2 10", "3/0: 3 4"));
}

TEST(DrawOnce, a_copy_is_left_out_and_restrictions_go_over_to_the_other) {
  for (const bool turned : {false, true}) {
    RoadNetwork roads{{}, {way_over(1, {1, 2, 3}), way_over(2, {1, 2, 3}), way_over(3, {3, 4})}};
    if (turned) std::ranges::reverse(roads.paths[1].nodes);
    roads.restrictions = {{2, 3, 3, false}};
    EXPECT_EQ(draw(roads), 1U);
    EXPECT_THAT(drawn(roads), ElementsAre("1/0: 1 2 3", "3/0: 3 4"));
    EXPECT_EQ(roads.restrictions[0].from_way, 1);
  }
}

TEST(DrawOnce, of_a_way_that_another_draws_in_part_the_rest_stays) {
  RoadNetwork roads{{}, {way_over(1, {1, 2, 3, 4, 5}), way_over(2, {2, 3}, "primary"), way_over(3, {2, 10})}};
  EXPECT_EQ(draw(roads), 1U);
  EXPECT_THAT(drawn(roads), ElementsAre("1/0: 1 2", "1/1: 3 4 5", "2/0: 2 3", "3/0: 2 10")) << "the class counts";
}

TEST(DrawOnce, a_one_way_copy_does_not_close_a_direction) {
  RoadNetwork roads{{}, {way_over(1, {2, 3}), way_over(2, {1, 2, 3, 4})}};
  roads.paths[0].oneway = Oneway::forward;
  EXPECT_EQ(draw(roads), 1U);
  EXPECT_THAT(drawn(roads), ElementsAre("2/0: 1 2 3 4"));
}

TEST(DrawOnce, one_line_for_each_direction_is_one_road) {
  RoadNetwork roads{{}, {way_over(1, {1, 2, 3}, "secondary"), way_over(2, {3, 2, 1}, "secondary")}};
  for (RoadPath& path : roads.paths) path.oneway = Oneway::forward;
  roads.paths[0].lanes = 2, roads.paths[0].turn_forward = "through|right", roads.paths[0].speed_limit_kmh = 70.0;
  roads.paths[1].lanes = 1, roads.paths[1].turn_forward = "left", roads.paths[1].speed_limit_kmh = 50.0;
  EXPECT_EQ(draw(roads), 1U);
  ASSERT_EQ(roads.paths.size(), 1U);
  const RoadPath& road = roads.paths[0];
  EXPECT_EQ(road.oneway, Oneway::no);
  EXPECT_EQ(std::tuple(road.lanes, road.lanes_forward, road.lanes_backward), std::tuple(3, 2, 1));
  EXPECT_EQ(road.turn_backward, "left");
  EXPECT_EQ(std::pair(road.speeds_forward, road.speeds_backward), std::pair(std::string("70"), std::string("50")));
  EXPECT_EQ(road.nodes[1].width_m, default_width_m("secondary", 3, Oneway::no));
}

TEST(DrawOnce, a_bus_lane_drawn_as_a_way_of_its_own_stays_one) {
  RoadNetwork roads{{}, {way_over(1, {1, 2, 3}, "secondary"), way_over(2, {3, 2, 1}, "secondary")}};
  for (RoadPath& path : roads.paths) path.oneway = Oneway::forward;
  roads.paths[0].lanes = 2, roads.paths[1].use = "bus";
  EXPECT_EQ(draw(roads), 1U);
  const RoadPath& road = roads.paths.at(0);
  EXPECT_EQ(std::tuple(road.lanes_forward, road.lanes_backward), std::tuple(2, 1));
  EXPECT_EQ(std::tuple(road.use, road.use_forward, road.use_backward), std::tuple("", "", "bus"));
}

TEST(DrawOnce, a_way_that_goes_back_on_itself_is_there_once) {
  RoadNetwork roads{{}, {way_over(1, {1, 2, 3, 2}), way_over(2, {5, 6, 10, 5, 6, 10, 5})}};
  EXPECT_EQ(draw(roads), 2U);
  EXPECT_THAT(drawn(roads), ElementsAre("1/0: 1 2 3", "2/0: 5 6 10 5")) << "a ring, drawn twice around";
}

TEST(DrawOnce, roads_of_two_levels_are_two) {
  RoadNetwork roads{{}, {way_over(1, {1, 2, 3}), way_over(2, {1, 2, 3})}};
  roads.paths[1].layer = 1, roads.paths[1].bridge = true;
  EXPECT_EQ(draw(roads), 0U);
}

TEST(DrawOnce, nodes_of_the_border_are_known_by_their_place) {
  RoadNetwork roads{{}, {way_over(1, {1, 2}), way_over(2, {1, 2}), way_over(3, {1, 3})}};
  for (RoadPath& path : roads.paths) path.nodes[1].osm_node = no_osm_node;
  EXPECT_EQ(draw(roads), 1U);
  EXPECT_EQ(roads.paths.size(), 2U);
}

}  // namespace
}  // namespace orthodrive
