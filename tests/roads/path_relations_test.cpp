// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "orthodrive/roads/path_crossings.hpp"
#include "orthodrive/roads/path_links.hpp"
#include "orthodrive/roads/ring_paths.hpp"

namespace orthodrive {
namespace {

RoadPath make_path(const std::vector<std::pair<Vec2, std::int64_t>>& nodes,
                   const std::string& highway = "residential") {
  RoadPath path;
  path.highway = highway;
  for (const auto& [p, id] : nodes) path.nodes.push_back({.p = p, .osm_node = id});
  return path;
}

/// One-way paths between corners of a polygon with that many, the last one back to the first.
RoadNetwork one_way_loop(int corners, double radius_m, int parts) {
  RoadNetwork roads;
  const auto corner = [&](int i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    return Vec2{100.0 + radius_m * std::cos(angle), 50.0 + radius_m * std::sin(angle)};
  };
  for (int part = 0; part < parts; ++part) {
    const int first = corners * part / parts, last = corners * (part + 1) / parts;
    std::vector<std::pair<Vec2, std::int64_t>> nodes;
    for (int i = first; i <= last; ++i) nodes.emplace_back(corner(i), 1 + i % corners);
    roads.paths.push_back(make_path(nodes));
    roads.paths.back().oneway = Oneway::forward;
  }
  return roads;
}

TEST(RingPaths, are_known_by_their_form) {
  RoadNetwork roads = one_way_loop(12, 14.0, 3);
  roads.paths.push_back(make_path({{{114, 50}, 1}, {{180, 50}, 50}}));  // an arm, driven both ways
  roads.paths.push_back(make_path({{{180, 60}, 51}, {{114, 50}, 1}}));  // one that leads in
  roads.paths.back().oneway = Oneway::forward;
  EXPECT_EQ(rings_of_paths(roads), (std::vector<int>{0, 0, 0, -1, -1}));
  EXPECT_EQ(rings_of_paths(one_way_loop(12, 14.0, 1)), std::vector<int>{0});
  RoadNetwork two = roads;
  for (RoadPath path : roads.paths) {
    for (RoadNode& node : path.nodes) node.p.x += 300.0, node.osm_node += 1000;
    two.paths.push_back(path);
  }
  two.paths[5].roundabout = two.paths[6].roundabout = true;
  EXPECT_EQ(rings_of_paths(two), (std::vector<int>{0, 0, 0, -1, -1, 1, 1, 1, -1, -1}));
}

TEST(RingPaths, are_no_blocks_of_houses_no_large_loops_and_no_streets_for_both_ways) {
  const std::vector<int> none(4, -1);
  EXPECT_EQ(rings_of_paths(one_way_loop(4, 30.0, 4)), none);
  EXPECT_EQ(rings_of_paths(one_way_loop(16, 60.0, 4)), none);
  RoadNetwork both_ways = one_way_loop(12, 14.0, 4);
  both_ways.paths[2].oneway = Oneway::no;
  EXPECT_EQ(rings_of_paths(both_ways), none);
  both_ways.paths[2].roundabout = true;
  EXPECT_EQ(rings_of_paths(both_ways), (std::vector<int>{-1, -1, 0, -1}));
}

TEST(PathLinks, the_straight_way_goes_on_at_a_junction) {
  const RoadNetwork roads{{},
                          {make_path({{{0, 0}, 1}, {{50, 0}, 2}}), make_path({{{50, 0}, 2}, {{60, 50}, 3}}),
                           make_path({{{100, 5}, 4}, {{50, 0}, 2}})}};
  const PathLinks links = link_path_ends(roads);
  ASSERT_EQ(links.size(), 2u);
  EXPECT_EQ(links.at({0, true}), (PathEnd{2, true}));
  EXPECT_EQ(links.at({2, true}), (PathEnd{0, true}));
}

TEST(PathLinks, two_ways_alone_at_a_node_may_bend_but_not_turn_back) {
  const auto count = [](Vec2 end) {
    return link_path_ends({{}, {make_path({{{0, 0}, 1}, {{50, 0}, 2}}), make_path({{{50, 0}, 2}, {end, 3}})}}).size();
  };
  EXPECT_EQ(count({50, 40}), 2u);
  EXPECT_EQ(count({10, 5}), 0u);
}

TEST(PathLinks, chains_hold_every_path_once_and_say_which_run_backwards) {
  const RoadNetwork roads{{},
                          {make_path({{{50, 0}, 2}, {{50, 60}, 5}}), make_path({{{100, 0}, 3}, {{50, 0}, 2}}),
                           make_path({{{0, 0}, 1}, {{50, 0}, 2}}),
                           make_path({{{300, 0}, 8}, {{320, 20}, 0}, {{280, 20}, 0}, {{300, 0}, 8}})}};
  const auto chains = chain_paths(roads, link_path_ends(roads));
  ASSERT_EQ(chains.size(), 3u);
  ASSERT_EQ(chains[1].paths.size(), 2u);
  EXPECT_EQ(chains[1].paths[0].path, 1u);
  EXPECT_FALSE(chains[1].paths[0].reversed);
  EXPECT_EQ(chains[1].paths[1].path, 2u);
  EXPECT_TRUE(chains[1].paths[1].reversed);
  EXPECT_FALSE(chains[1].closed);
  const RoadNetwork ring{
      {},
      {make_path({{{0, 0}, 1}, {{30, 0}, 0}, {{30, 30}, 2}}), make_path({{{0, 0}, 1}, {{0, 30}, 0}, {{30, 30}, 2}})}};
  const auto round = chain_paths(ring, link_path_ends(ring));
  ASSERT_EQ(round.size(), 1u);
  EXPECT_TRUE(round[0].closed);
  EXPECT_TRUE(round[0].paths[1].reversed);
}

TEST(PathCrossings, found_once_with_their_place) {
  // The crossing lies on a node of both lines and on a corner of the search grid.
  const RoadNetwork roads{{},
                          {make_path({{{0, 50}, 1}, {{50, 50}, 0}, {{120, 50}, 2}}),
                           make_path({{{50, -30}, 3}, {{50, 50}, 0}, {{50, 90}, 4}})}};
  const auto crossings = find_crossings(roads);
  ASSERT_EQ(crossings.size(), 1u);
  EXPECT_NEAR(distance(crossings[0].p, {50, 50}), 0.0, 1e-9);
  EXPECT_EQ(crossings[0].path_a, 0u);
  EXPECT_EQ(crossings[0].path_b, 1u);
}

TEST(PathCrossings, ways_that_share_a_node_there_do_not_cross) {
  const RoadNetwork meeting{
      {},
      {make_path({{{0, 0}, 1}, {{10, 0}, 9}, {{20, 0}, 2}}), make_path({{{10, -9}, 3}, {{10, 0}, 9}, {{10, 9}, 4}})}};
  EXPECT_TRUE(find_crossings(meeting).empty());
  const RoadNetwork apart{{}, {make_path({{{0, 0}, 1}, {{20, 0}, 2}}), make_path({{{0, 5}, 3}, {{20, 5}, 4}})}};
  EXPECT_TRUE(find_crossings(apart).empty());
}

}  // namespace
}  // namespace orthodrive
