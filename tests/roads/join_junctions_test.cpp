// SPDX-License-Identifier: Apache-2.0
// Junctions where lines meet: checked against solutions by hand.

#include "orthodrive/roads/join_junctions.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

/// A straight chain with a node every 2 m; `at` nodes are OSM nodes.
RoadChain straight_chain(Vec2 from, Vec2 to, const std::vector<std::pair<std::size_t, std::int64_t>>& at,
                         int rank = 0) {
  RoadChain chain;
  chain.rank = rank;
  const int count = static_cast<int>(std::lround(distance(from, to) / 2.0));
  for (int i = 0; i <= count; ++i)
    chain.nodes.push_back({.base = from + (to - from) * (static_cast<double>(i) / count), .s_m = 2.0 * i});
  for (const auto& [node, id] : at) chain.nodes[node].osm_node = id;
  return chain;
}

Polyline shifted(const RoadChain& chain, Vec2 by) {
  Polyline line;
  for (const ChainNode& node : chain.nodes) line.push_back(node.base + by);
  return line;
}

constexpr double solver_m = 1e-4;  // Levenberg and Marquardt's damping leaves some 20 micrometres

/// Two roads of 100 m that cross at the origin, node 25 of both; the fitted lines lie at y = 0.4 and x = -0.3.
struct Crossing {
  std::vector<RoadChain> chains;
  std::vector<Polyline> lines;
  explicit Crossing(int rank_a = 0, int rank_b = 0)
      : chains{straight_chain({-50, 0}, {50, 0}, {{25, 7}}, rank_a),
               straight_chain({0, -50}, {0, 50}, {{25, 7}}, rank_b)},
        lines{shifted(chains[0], {0, 0.4}), shifted(chains[1], {-0.3, 0})} {}
};

TEST(PlaceJunctions, lies_where_the_lines_cross) {
  const Crossing crossing;
  const auto places = place_junctions(crossing.chains, crossing.lines);
  ASSERT_EQ(places.size(), 1u);
  // Across: (x + 0.3)^2 and (y - 0.4)^2; along, at a fifth of the weight: 0.04 x^2 and 0.04 y^2.
  EXPECT_NEAR(places[0].p.x, -0.3 / 1.04, solver_m);
  EXPECT_NEAR(places[0].p.y, 0.4 / 1.04, solver_m);
  ASSERT_EQ(places[0].passes.size(), 2u);
  EXPECT_EQ(places[0].passes[0].chain, 0u);
  EXPECT_EQ(places[0].passes[1].chain, 1u);
  EXPECT_EQ(places[0].passes[1].node, 25u);
}

TEST(PlaceJunctions, roads_of_a_higher_class_count_more) {
  const Crossing crossing(3, 0);  // weights 4 and 1
  const auto places = place_junctions(crossing.chains, crossing.lines);
  ASSERT_EQ(places.size(), 1u);
  EXPECT_NEAR(places[0].p.x, -0.3 / (1.0 + 0.04 * 16.0), solver_m);
  EXPECT_NEAR(places[0].p.y, 0.4 * 16.0 / (16.0 + 0.04), solver_m);
  EXPECT_NEAR(places[0].passes[0].sigma_m, 4.0 * places[0].passes[1].sigma_m, 1e-12);
}

TEST(PlaceJunctions, a_road_that_ends_counts_half) {
  const std::vector<RoadChain> chains{straight_chain({-50, 0}, {50, 0}, {{25, 7}}),
                                      straight_chain({0, 0}, {0, 50}, {{0, 7}})};
  const auto places = place_junctions(chains, {shifted(chains[0], {0, 0.4}), shifted(chains[1], {-0.3, 0})});
  ASSERT_EQ(places.size(), 1u);
  EXPECT_NEAR(places[0].p.x, -0.3 * 0.25 / (0.25 + 0.04), solver_m);
  EXPECT_NEAR(places[0].p.y, 0.4 / (1.0 + 0.04 * 0.25), solver_m);
}

TEST(PlaceJunctions, junctions_on_a_short_link_move_alike) {
  // A main road through two junctions, 4 m or 40 m apart; at one of them a road crosses that lies 1 m to the east.
  const auto apart_m = [](std::size_t steps) {
    const std::vector<RoadChain> chains{straight_chain({-50, 0}, {50, 0}, {{25, 1}, {25 + steps, 2}}),
                                        straight_chain({0, -50}, {0, 50}, {{25, 1}}),
                                        straight_chain({2.0 * steps, -50}, {2.0 * steps, 50}, {{25, 2}})};
    const auto places =
        place_junctions(chains, {shifted(chains[0], {}), shifted(chains[1], {}), shifted(chains[2], {1.0, 0.0})});
    EXPECT_EQ(places.size(), 2u);
    return places[1].p.x - places[0].p.x - 2.0 * static_cast<double>(steps);
  };
  EXPECT_LT(apart_m(2), 0.05);
  EXPECT_GT(apart_m(20), 0.5);
  EXPECT_GT(apart_m(2), 0.0);
}

TEST(PlaceJunctions, nodes_of_one_road_are_no_junction) {
  EXPECT_TRUE(place_junctions({}, {}).empty());
  const std::vector<RoadChain> one{straight_chain({-50, 0}, {50, 0}, {{0, 1}, {25, 2}})};
  EXPECT_TRUE(place_junctions(one, {shifted(one[0], {})}).empty());
}

TEST(BendToJunctions, meets_the_place_and_fades_out_within_the_reach) {
  const Crossing crossing;
  std::vector<Polyline> lines = crossing.lines;
  const Vec2 place{-0.25, 0.3};
  bend_to_junctions(crossing.chains, {{place, {{0, 25, 0.1}, {1, 25, 0.1}}}}, lines, 20.0);
  for (std::size_t c = 0; c < 2; ++c) {
    EXPECT_TRUE(lines[c][25] == place);
    const Vec2 move = place - crossing.lines[c][25];
    for (std::size_t i = 0; i < lines[c].size(); ++i) {
      // A cubic from 1 to 0 with slope 0 at both ends.
      const double x = std::abs(crossing.chains[c].nodes[i].s_m - 50.0) / 20.0;
      const double share = x >= 1.0 ? 0.0 : 1.0 - 3.0 * x * x + 2.0 * x * x * x;
      EXPECT_LT(distance(lines[c][i], crossing.lines[c][i] + move * share), 1e-12) << c << " " << i;
    }
  }
}

TEST(BendToJunctions, near_junctions_do_not_move_each_other) {
  const RoadChain chain = straight_chain({0, 0}, {100, 0}, {});
  std::vector<Polyline> lines{shifted(chain, {})};
  bend_to_junctions({chain}, {{{40, 1.0}, {{0, 20, 0.1}}}, {{46, -1.0}, {{0, 23, 0.1}}}}, lines, 25.0);
  EXPECT_TRUE(lines[0][20] == (Vec2{40, 1.0}));
  EXPECT_TRUE(lines[0][23] == (Vec2{46, -1.0}));
  EXPECT_GT(lines[0][10].y, 0.0) << "outwards the whole reach counts";
  EXPECT_LT(lines[0][33].y, 0.0);
  EXPECT_EQ(lines[0][7].y, 0.0);
}

TEST(BendToJunctions, a_move_ends_at_the_next_junction) {
  const RoadChain chain = straight_chain({0, 0}, {100, 0}, {});
  const auto bent = [&](double y_first, double y_second) {
    std::vector<Polyline> lines{shifted(chain, {})};
    bend_to_junctions({chain}, {{{40, y_first}, {{0, 20, 0.1}}}, {{46, y_second}, {{0, 23, 0.1}}}}, lines, 25.0);
    return lines[0];
  };
  const Polyline ahead = bent(1.0, 0.0), behind = bent(0.0, 1.0);
  for (std::size_t i = 23; i <= 50; ++i) EXPECT_EQ(ahead[i].y, 0.0) << i;
  for (std::size_t i = 0; i <= 20; ++i) EXPECT_EQ(behind[i].y, 0.0) << i;
  EXPECT_GT(ahead[22].y, 0.0);
  EXPECT_GT(behind[21].y, 0.0);
}

TEST(BendToJunctions, closed_lines_stay_closed_and_bend_across_their_seam) {
  RoadChain ring;
  ring.closed = true;
  Polyline line;
  const double radius_m = 20.0, turn = 2.0 * M_PI;
  for (int i = 0; i <= 60; ++i) {
    const Vec2 p = Vec2{std::cos(turn * i / 60), std::sin(turn * i / 60)} * radius_m;
    ring.nodes.push_back({.base = p, .s_m = turn * radius_m * i / 60});
    line.push_back(p);
  }
  line.back() = line.front();
  std::vector<Polyline> lines{line};
  bend_to_junctions({ring}, {{{21.0, 0.0}, {{0, 0, 0.1}}}}, lines, 10.0);
  EXPECT_TRUE(lines[0].front() == (Vec2{21.0, 0.0}));
  EXPECT_TRUE(lines[0].back() == lines[0].front());
  for (const std::size_t i : {1u, 2u, 3u})  // the same to both sides of the seam
    EXPECT_NEAR(lines[0][i].x - line[i].x, lines[0][60 - i].x - line[60 - i].x, 1e-12) << i;
  EXPECT_GT(lines[0][1].x, line[1].x + 0.5);
  EXPECT_TRUE(lines[0][30] == line[30]);
}

}  // namespace
}  // namespace orthodrive
