// SPDX-License-Identifier: Apache-2.0
// One-way roads that nobody can enter or leave, and the borders of maps, where nothing is said.
#include "orthodrive/roads/dead_one_ways.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace orthodrive {
namespace {
using ::testing::ElementsAre;
using ::testing::IsEmpty;

RoadPath street(std::int64_t way, const std::vector<std::pair<std::int64_t, Vec2>>& nodes, Oneway oneway = Oneway::no) {
  RoadPath path{.osm_id = way, .highway = "residential", .oneway = oneway};
  for (const auto& [id, p] : nodes) {
    const double s_m = path.nodes.empty() ? 0.0 : path.nodes.back().s_m + distance(path.nodes.back().p, p);
    path.nodes.push_back({.p = p, .osm_node = id, .s_m = s_m, .width_m = 5.0});
  }
  return path;
}
RoadPath one_way(std::int64_t way, const std::vector<std::pair<std::int64_t, Vec2>>& nodes) {
  return street(way, nodes, Oneway::forward);
}

std::vector<std::string> told(const std::vector<RoadPath>& paths) {
  Findings findings;
  report_dead_one_ways({{}, paths}, findings);
  std::vector<std::string> codes;
  for (const Finding& finding : findings)
    codes.push_back(finding.code + (finding.x_m == 0.0 && finding.y_m == 0.0 ? "" : " elsewhere"));
  return codes;
}

/// Streets around the origin, 200 m away, that meet nothing there.
std::vector<RoadPath> block() {
  return {street(90, {{90, {-200, -200}}, {91, {0, -200}}, {92, {200, -200}}}),
          street(91, {{92, {200, -200}}, {93, {200, 0}}, {94, {200, 200}}}),
          street(92, {{94, {200, 200}}, {95, {0, 200}}, {96, {-200, 200}}}),
          street(93, {{96, {-200, 200}}, {97, {-200, 0}}, {90, {-200, -200}}})};
}
std::vector<RoadPath> with(std::vector<RoadPath> paths, const std::vector<RoadPath>& more) {
  paths.insert(paths.end(), more.begin(), more.end());
  return paths;
}

TEST(DeadOneWays, two_that_leave_a_node_that_nothing_enters) {
  const RoadPath east = one_way(1, {{1, {0, 0}}, {2, {100, 0}}}), west = one_way(2, {{1, {0, 0}}, {3, {-100, 10}}});
  EXPECT_THAT(told({east, west}), ElementsAre("osm.no_way_in"));
  RoadPath back_east = one_way(1, {{2, {100, 0}}, {1, {0, 0}}}), back_west = one_way(2, {{3, {-100, 10}}, {1, {0, 0}}});
  EXPECT_THAT(told({back_east, back_west}), ElementsAre("osm.no_way_out"));
  EXPECT_THAT(told({east, back_west}), IsEmpty());
  EXPECT_THAT(told({east, west, street(3, {{1, {0, 0}}, {4, {0, 50}}})}), IsEmpty());
  EXPECT_THAT(told({east, west, one_way(3, {{5, {0, -50}}, {1, {0, 0}}, {4, {0, 50}}})}), IsEmpty()) << "crosses";
  RoadPath with_bus = east;
  with_bus.lanes_backward = 1;
  EXPECT_THAT(told({with_bus, west}), IsEmpty());
}

TEST(DeadOneWays, a_fork_is_told_inside_a_map_alone) {
  const std::vector<RoadPath> fork{one_way(1, {{1, {0, 0}}, {2, {100, 20}}}),
                                   one_way(2, {{1, {0, 0}}, {3, {100, -20}}})};
  EXPECT_THAT(told(fork), IsEmpty()) << "the road that leads there may lie beyond the border";
  EXPECT_THAT(told(with(block(), fork)), ElementsAre("osm.no_way_in"));
  std::vector<RoadPath> half = with(block(), fork);
  half.erase(half.begin() + 3);  // nothing in the west
  std::erase_if(half[0].nodes, [](const RoadNode& node) { return node.p.x < 0; });
  std::erase_if(half[2].nodes, [](const RoadNode& node) { return node.p.x < 0; });
  EXPECT_THAT(told(half), IsEmpty());
}

TEST(DeadOneWays, a_road_that_begins_alone_may_go_on_beyond_the_border) {
  EXPECT_THAT(told(with(block(), {one_way(1, {{1, {0, 0}}, {95, {0, 200}}})})), IsEmpty());
  EXPECT_THAT(told(with(block(), {one_way(1, {{95, {0, 200}}, {1, {0, 0}}})})), IsEmpty());
}

TEST(DeadOneWays, rings_and_ways_that_go_on_say_nothing) {
  const RoadPath ring = one_way(1, {{1, {0, 0}}, {2, {50, 0}}, {3, {50, 50}}, {1, {0, 0}}});
  EXPECT_THAT(told(with(block(), {ring})), IsEmpty());
  EXPECT_THAT(
      told(with(block(), {one_way(1, {{91, {0, -200}}, {1, {0, 0}}}), one_way(2, {{1, {0, 0}}, {95, {0, 200}}})})),
      IsEmpty());
}

TEST(DeadOneWays, the_order_of_ways_and_ids_changes_nothing) {
  std::vector<RoadPath> paths{one_way(1, {{1, {0, 0}}, {2, {100, 0}}}), one_way(2, {{1, {0, 0}}, {3, {-100, 0}}}),
                              one_way(3, {{2, {100, 0}}, {7, {200, 0}}}), one_way(4, {{8, {300, 0}}, {7, {200, 0}}})};
  Findings first, second;
  report_dead_one_ways({{}, paths}, first);
  std::ranges::reverse(paths);
  report_dead_one_ways({{}, paths}, second);
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(first[0].code, "osm.no_way_in");
  EXPECT_EQ(first[1].code, "osm.no_way_out");
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].message, second[i].message);
}

}  // namespace
}  // namespace orthodrive
