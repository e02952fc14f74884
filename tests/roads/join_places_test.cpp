// SPDX-License-Identifier: Apache-2.0
// Roads that meet in one place without a common node.
#include "orthodrive/roads/join_places.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace orthodrive {
namespace {

RoadPath path_of(std::int64_t way, const std::vector<std::pair<Vec2, std::int64_t>>& nodes, double width_m = 6.5) {
  RoadPath path{.osm_id = way, .highway = "residential"};
  for (const auto& [p, id] : nodes) {
    const double s_m = path.nodes.empty() ? 0.0 : path.nodes.back().s_m + distance(path.nodes.back().p, p);
    path.nodes.push_back({.p = p, .osm_node = id, .s_m = s_m, .width_m = width_m});
  }
  return path;
}

std::vector<std::string> codes_of(const Findings& findings) {
  std::vector<std::string> codes;
  for (const Finding& finding : findings) codes.push_back(finding.code);
  return codes;
}

TEST(JoinPlaces, nodes_in_one_place_are_one) {
  RoadNetwork roads{{},
                    {path_of(1, {{{0, 0}, 1}, {{50, 0}, 2}, {{100, 0}, 3}}), path_of(2, {{{50, 0}, 4}, {{50, 60}, 5}}),
                     path_of(3, {{{50, -60}, 7}, {{50, 0.01}, 6}})}};
  roads.restrictions = {{2, 4, 3, false}};
  roads.signs = {{4, NodeSignKind::stop, 0}, {6, NodeSignKind::stop, 0}};
  Findings findings;
  join_places(roads, findings);
  EXPECT_THAT(codes_of(findings), testing::ElementsAre("osm.nodes_in_one_place"));
  EXPECT_EQ(roads.paths[1].nodes.front().osm_node, 2);
  EXPECT_EQ(roads.paths[2].nodes.back().osm_node, 2);
  EXPECT_EQ(roads.paths[2].nodes.back().p, (Vec2{50, 0}));
  EXPECT_EQ(roads.restrictions[0].via_node, 2);
  ASSERT_EQ(roads.signs.size(), 1U);
  EXPECT_EQ(roads.signs[0].osm_node, 2);
}

TEST(JoinPlaces, a_bridge_over_a_node_stays_apart_but_meets_its_road_at_the_end) {
  RoadNetwork roads{
      {},
      {path_of(1, {{{0, 0}, 1}, {{50, 0}, 2}, {{100, 0}, 3}}),
       path_of(2, {{{50, -20}, 4}, {{50, 0}, 5}, {{50, 20}, 6}}), path_of(3, {{{50, 20}, 7}, {{50, 90}, 8}})}};
  roads.paths[1].bridge = true, roads.paths[1].layer = 1;
  Findings findings;
  join_places(roads, findings);
  EXPECT_EQ(roads.paths[1].nodes[1].osm_node, 5) << "over the road";
  EXPECT_EQ(roads.paths[2].nodes[0].osm_node, 6) << "at the abutment";
}

TEST(JoinPlaces, ends_on_a_carriageway_join_it) {
  RoadNetwork roads{
      {},
      {path_of(1, {{{0, 0}, 1}, {{100, 0}, 2}, {{200, 0}, 3}}), path_of(2, {{{30, 0.1}, 4}, {{30, 60}, 5}}),
       path_of(3, {{{60, -60}, 6}, {{60, -2.3}, 7}}), path_of(4, {{{99.5, 2}, 8}, {{99, 60}, 9}}),
       path_of(5, {{{150, -40}, 10}, {{150, 1.0}, 11}}), path_of(6, {{{180, 4.0}, 12}, {{180, 60}, 13}})}};
  Findings findings;
  join_places(roads, findings);
  EXPECT_THAT(codes_of(findings),
              testing::ElementsAre("osm.end_joined", "osm.end_joined", "osm.end_joined", "osm.end_joined"));
  std::vector<std::int64_t> ids;
  for (const RoadNode& node : roads.paths[0].nodes) ids.push_back(node.osm_node);
  EXPECT_THAT(ids, testing::ElementsAre(1, 4, 7, 2, 11, 3));
  EXPECT_EQ(roads.paths[1].nodes[0].p, (Vec2{30, 0}));
  EXPECT_EQ(roads.paths[3].nodes[0].osm_node, 2) << "a vertex is near";
  EXPECT_EQ(roads.paths[3].nodes[0].p, (Vec2{100, 0}));
  EXPECT_EQ(roads.paths[4].nodes[1].p, (Vec2{150, 0})) << "drawn across";
  EXPECT_EQ(roads.paths[5].nodes[0].osm_node, 12) << "beside the asphalt";
  for (const RoadPath& path : roads.paths) EXPECT_NEAR(path.nodes.back().s_m, length_m(centerline(path)), 1e-9);
}

TEST(JoinPlaces, other_levels_roads_alongside_and_stubs_stay) {
  RoadNetwork roads{{},
                    {path_of(1, {{{0, 0}, 1}, {{200, 0}, 3}}), path_of(2, {{{30, 1}, 4}, {{30, 60}, 5}}),
                     path_of(3, {{{60, 2}, 6}, {{140, 3}, 7}}), path_of(4, {{{200, 0}, 3}, {{198, 2}, 8}})}};
  roads.paths[1].layer = 1, roads.paths[1].bridge = true;
  const RoadNetwork before = roads;
  Findings findings;
  join_places(roads, findings);
  EXPECT_EQ(std::set<std::string>({"osm.end_on_road"}), [&] {
    const std::vector<std::string> codes = codes_of(findings);
    return std::set<std::string>(codes.begin(), codes.end());
  }());
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    ASSERT_EQ(roads.paths[p].nodes.size(), before.paths[p].nodes.size());
    EXPECT_EQ(roads.paths[p].nodes.back().osm_node, before.paths[p].nodes.back().osm_node);
  }
}

TEST(JoinPlaces, two_ends_that_lie_by_each_other_become_one) {
  RoadNetwork roads{{}, {path_of(1, {{{0, 0}, 1}, {{50, 0}, 2}}), path_of(2, {{{50.5, 0.5}, 3}, {{100, 0}, 4}})}};
  Findings findings;
  join_places(roads, findings);
  EXPECT_EQ(roads.paths[0].nodes.back().osm_node, roads.paths[1].nodes.front().osm_node);
  EXPECT_EQ(roads.paths[0].nodes.back().p, roads.paths[1].nodes.front().p);
}

TEST(JoinPlaces, the_result_does_not_depend_on_ids) {
  const auto shape = [](std::int64_t sign) {
    RoadNetwork roads{{},
                      {path_of(1, {{{0, 0}, sign * 9}, {{100, 0}, sign * 2}}),
                       path_of(2, {{{30, 0.1}, sign * 4}, {{30, 60}, sign * 7}}),
                       path_of(3, {{{100, 0}, sign * 1}, {{130, 60}, sign * 8}})}};
    Findings findings;
    join_places(roads, findings);
    std::vector<Vec2> places;
    for (const RoadPath& path : roads.paths)
      for (const RoadNode& node : path.nodes) places.push_back(node.p);
    EXPECT_EQ(roads.paths[2].nodes[0].osm_node, roads.paths[0].nodes.back().osm_node);
    return places;
  };
  EXPECT_EQ(shape(1), shape(-1));
}

}  // namespace
}  // namespace orthodrive
