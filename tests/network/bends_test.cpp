// SPDX-License-Identifier: Apache-2.0
// Bends on slopes: heights and bankings of bends that were eased, and how fast roads may turn about their line.

#include <gtest/gtest.h>

#include <cmath>

#include "network_support.hpp"
#include "orthodrive/network/line/chain_line.hpp"
#include "orthodrive/network/line/lay_bends.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;

TEST(Bends, EasedCornersLieInThePlaneThatTheirNodesLayIn) {
  // 120 degrees between two ways: nodes move by up to 3 m, by 16 cm in height.
  const Vec2 slope{0.05, -0.04};
  const auto height = [&](Vec2 p) { return 30.0 + dot(slope, p); };
  const auto way = [&](std::int64_t id, Vec2 a, Vec2 b, std::int64_t node_a, std::int64_t node_b) {
    const double banking = std::atan(dot(slope, left_normal(normalized(b - a))));
    return make_path(
        {a, b}, {node_a, node_b},
        {.osm_id = id, .width_m = 5.4, .height = height, .banking = [banking](double) { return banking; }});
  };
  const auto map = build_network(network_of({way(1, {0, 80}, {0, 0}, 1, 2), way(2, {0, 0}, {-60, 35}, 2, 3)})).map;
  for (const Road& road : map.roads)
    for (double s = 0.0; s <= road.length; s += 0.25) {
      const roadquery::PlanPoint p = roadquery::reference_point(road, s);
      const Vec2 left{-std::sin(p.hdg), std::cos(p.hdg)};
      EXPECT_NEAR(roadquery::elevation(road, s), height(Vec2{p.x, p.y} - site_origin), 0.025) << s;
      EXPECT_NEAR(std::tan(roadquery::superelevation(road, s)), dot(slope, left), 0.015) << s;
    }
}

TEST(Bends, AnEasedCornerOfAClosedWayHasNoSeam) {
  // The corner is where the way begins and ends.
  const Vec2 slope{0.05, -0.04};
  const auto banking = [&](double s) {
    const Vec2 direction = s < 60.0 ? Vec2{1, 0} : s < 120.0 ? Vec2{0, 1} : normalized(Vec2{-1, -1});
    return std::atan(dot(slope, left_normal(direction)));
  };
  const RoadNetwork roads = network_of(
      {make_path({{0, 0}, {60, 0}, {60, 60}, {0, 0}}, {1, 0, 0, 1},
                 {.width_m = 5.0, .height = [&](Vec2 p) { return 30.0 + dot(slope, p); }, .banking = banking})});
  const auto map = build_network(roads).map;
  expect_sound(map);
  for (const Road& road : map.roads)
    for (double s = 0.0; s <= road.length; s += 0.25) {
      const roadquery::PlanPoint p = roadquery::reference_point(road, s);
      EXPECT_NEAR(roadquery::elevation(road, s), 30.0 + dot(slope, Vec2{p.x, p.y} - site_origin), 0.03) << s;
    }
}

TEST(Bends, ABendThatHardlyMovesKeepsHeightsThatNoPlaneHas) {
  // A quarter circle with a wave of 12 cm along it; its middle moves outwards by `moved_m`.
  const auto laid = [](double moved_m, double wave_m) {
    std::vector<network::ChainLineNode> before;
    std::vector<std::size_t> was;
    for (int i = 0; i <= 40; ++i) {
      const double angle = 0.5 * M_PI * i / 40.0;
      const Vec2 p = Vec2{std::cos(angle), std::sin(angle)} * 25.0;
      before.push_back({.p = p,
                        .z_m = 30.0 + 0.05 * p.x + wave_m * std::cos(8.0 * angle),
                        .width_before_m = 10.0,
                        .width_after_m = 10.0});
      was.push_back(was.size());
    }
    auto nodes = before;
    for (std::size_t i = 14; i <= 26; ++i) nodes[i].p = nodes[i].p * (1.0 + moved_m / 25.0);
    network::lay_bends(nodes, before, was, false);
    double most_m = 0.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) most_m = std::max(most_m, std::abs(nodes[i].z_m - before[i].z_m));
    return most_m;
  };
  EXPECT_EQ(laid(0.3, 0.12), 0.0) << "the plane would miss the wave by 10 cm, the old heights the slope by 1";
  EXPECT_GT(laid(3.0, 0.0), 0.02) << "what moves far goes on in the plane of the slope";
}

/// Of the one road of a map: by how much it turns a metre beyond what a plane does in a bend.
double largest_warp(const roadquery::RoadMap& map) {
  constexpr double over_m = 1.0;
  const Road& road = map.roads.at(0);
  double largest = 0.0;
  for (double s = 0.0; s + over_m <= road.length; s += 0.25) {
    const double change =
        std::tan(roadquery::superelevation(road, s + over_m)) - std::tan(roadquery::superelevation(road, s));
    const double turn = std::remainder(
        roadquery::reference_point(road, s + over_m).hdg - roadquery::reference_point(road, s).hdg, 2.0 * M_PI);
    largest = std::max(largest, std::abs(change + turn * roadquery::gradient(road, s + 0.5 * over_m)) / over_m);
  }
  return largest;
}

TEST(Bends, BankingThatTurnsTooFastIsSlowed) {
  const auto banking = [](double s) { return s < 50.0 ? -0.06 : 0.06; };
  const auto map = build_network(network_of({make_path({{0, 0}, {100, 0}}, {1, 2}, {.banking = banking})})).map;
  EXPECT_LT(largest_warp(map), 0.016);
  EXPECT_NEAR(roadquery::superelevation(map.roads.at(0), 40.0), -0.06, 0.003) << "and nothing else changes";
  EXPECT_NEAR(roadquery::superelevation(map.roads.at(0), 60.0), 0.06, 0.003);
}

TEST(Bends, SteepHairpinsTurnWithTheirPlane) {
  // 14 % and level across on a radius of 10 m: 1.4 % a metre on the line, twice that inside.
  std::vector<Vec2> line{{-40, -10}};
  for (const Vec2 p : circle_points({0, 0}, 10.0, -0.5 * M_PI, M_PI)) line.push_back(p);
  line.push_back({-40, 10});
  RoadPath path = make_path(line, {1}, {});
  for (RoadNode& node : path.nodes) node.z_m = 20.0 + 0.14 * node.s_m, node.gradient = 0.14;
  path.nodes.back().osm_node = 2;
  EXPECT_LT(largest_warp(build_network(network_of({path})).map), 0.012);
}

}  // namespace
}  // namespace orthodrive
