#include <gtest/gtest.h>

#include "orthodrive/roads/path_crossings.hpp"
#include "orthodrive/roads/path_links.hpp"

namespace orthodrive {
namespace {

RoadPath make_path(std::vector<std::pair<Vec2, std::int64_t>> nodes, const std::string& highway = "residential") {
  RoadPath path;
  path.highway = highway;
  for (const auto& [p, id] : nodes) path.nodes.push_back({.p = p, .osm_node = id});
  return path;
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
