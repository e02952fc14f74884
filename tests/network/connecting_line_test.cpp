// SPDX-License-Identifier: Apache-2.0
// Lines of connecting roads, and lanes beside them.

#include "orthodrive/network/line/connecting_line.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "network_support.hpp"
#include "orthodrive/network/curves/ease_along.hpp"

namespace orthodrive::network_test {
namespace {

using network::ChainGeometries;
using network::ChainIndex;
using network::connecting_line;
using network::pose_at;

/// A straight chain.
network::ChainGeometry straight(Vec2 from, Vec2 to) {
  const Vec2 d = to - from;
  network::ChainGeometry chain;
  chain.length_m = length(d);
  chain.plan.push_back({0.0, from.x, from.y, std::atan2(d.y, d.x), chain.length_m, roadquery::Line{}});
  return chain;
}

/// One to the east up to the origin, one on from there to the north, 200 m each.
ChainGeometries corner() {
  ChainGeometries chains;
  chains.push_back(straight({-200, 0}, {0, 0}));
  chains.push_back(straight({0, 0}, {0, 200}));
  return chains;
}

double sharpest(const std::vector<roadquery::PlanElement>& line) {
  double most = 0.0;
  for (const roadquery::PlanElement& e : line)
    for (const double s : {0.0, 0.5 * e.length, e.length})
      most = std::max(most, std::abs(roadquery::evaluate(e, s).curvature));
  return most;
}

void expect_smooth(const std::vector<roadquery::PlanElement>& line) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const roadquery::PlanPoint end = roadquery::evaluate(line[i], line[i].length);
    EXPECT_NEAR(line[i].s + line[i].length, line[i + 1].s, 1e-9);
    EXPECT_LT(std::hypot(end.x - line[i + 1].x, end.y - line[i + 1].y), 1e-6);
    EXPECT_LT(std::abs(std::remainder(end.hdg - line[i + 1].hdg, 2.0 * std::numbers::pi)), 1e-6);
  }
}

void expect_ends(const std::vector<roadquery::PlanElement>& line, Vec2 from, Vec2 to) {
  EXPECT_LT(distance(pose_at(line, 0.0).p, from), 1e-6);
  EXPECT_LT(distance(pose_at(line, network::plan_length(line)).p, to), 1e-6);
  expect_smooth(line);
}

TEST(ConnectingLine, between_near_cuts_is_one_turn) {
  const auto line = connecting_line(corner(), {{ChainIndex(0), 194, 200}, {ChainIndex(1), 0, 6}}, 14.0);
  expect_ends(line, {-6, 0}, {0, 6});
  ASSERT_EQ(line.size(), 1u);
  EXPECT_NEAR(sharpest(line), 1.0 / 6.0, 1e-6);  // a quarter of a circle
}

TEST(ConnectingLine, is_straight_where_it_leaves_and_enters_a_road) {
  const auto line = connecting_line(corner(), {{ChainIndex(0), 188, 200}, {ChainIndex(1), 0, 12}}, 14.0);
  expect_ends(line, {-12, 0}, {0, 12});
  EXPECT_NEAR(network::plan_length(line), 4.0 + 8.0 * std::numbers::pi / 2 + 4.0, 1e-6);
  EXPECT_NEAR(pose_at(line, 3.9).p.y, 0.0, 1e-9);
}

TEST(ConnectingLine, keeps_to_the_roads_where_the_cuts_are_far) {
  const auto line = connecting_line(corner(), {{ChainIndex(0), 140, 200}, {ChainIndex(1), 0, 50}}, 14.0);
  expect_ends(line, {-60, 0}, {0, 50});
  EXPECT_NEAR(network::plan_length(line), 45.0 + 35.0 + 15.0 * std::numbers::pi / 2, 1e-6);
  EXPECT_NEAR(sharpest(line), 1.0 / 15.0, 1e-6);
  for (double s = 0.0; s < 45.0; s += 1.0) EXPECT_NEAR(pose_at(line, s).p.y, 0.0, 1e-9);
}

TEST(ConnectingLine, drives_chains_against_their_direction) {
  const auto line = connecting_line(corner(), {{ChainIndex(1), 50, 0}, {ChainIndex(0), 200, 140}}, 14.0);
  expect_ends(line, {0, 50}, {-60, 0});
  EXPECT_NEAR(sharpest(line), 1.0 / 15.0, 1e-6);
}

TEST(ConnectingLine, takes_more_room_for_sharp_turns_and_for_fast_ones) {
  ChainGeometries chains = corner();
  const double back = 140.0 * std::numbers::pi / 180.0, fork = 8.0 * std::numbers::pi / 180.0;
  chains.push_back(straight({0, 0}, Vec2{std::cos(back), std::sin(back)} * 200.0));
  chains.push_back(straight({0, 0}, Vec2{std::cos(fork), std::sin(fork)} * 200.0));
  EXPECT_LT(sharpest(connecting_line(chains, {{ChainIndex(0), 120, 200}, {ChainIndex(2), 0, 80}}, 14.0)), 1.0 / 11.9);
  const double v = 36.0;
  EXPECT_LT(v * v * sharpest(connecting_line(chains, {{ChainIndex(0), 120, 200}, {ChainIndex(3), 0, 80}}, v)), 1.51);
}

TEST(ConnectingLine, follows_a_way_inside_the_junction_but_not_a_short_one) {
  ChainGeometries chains;
  for (const double inner_m : {60.0, 12.0}) {
    const std::size_t first = chains.size();
    chains.push_back(straight({-200, 0}, {0, 0}));
    chains.push_back(straight({0, 0}, {0, inner_m}));
    chains.push_back(straight({0, inner_m}, {200, inner_m}));
    const auto line = connecting_line(
        chains, {{ChainIndex(first), 160, 200}, {ChainIndex(first + 1), 0, inner_m}, {ChainIndex(first + 2), 0, 40}},
        8.0);
    expect_ends(line, {-40, 0}, {40, inner_m});
    double nearest = INFINITY;
    for (double s = 0.0; s < network::plan_length(line); s += 0.5)
      nearest = std::min(nearest, distance(pose_at(line, s).p, {0, 0.5 * inner_m}));
    EXPECT_LT(nearest, 0.3);
    EXPECT_LT(sharpest(line), 1.0 / 7.0);
  }
}

/// A line beside a line, from the values of cubics: where it lies and where it heads at a place of an element.
double heading_beside(const std::vector<roadquery::PlanElement>& line, const std::vector<roadquery::Cubic>& offset,
                      std::size_t element, double ds) {
  const roadquery::PlanElement& e = line[element];
  const roadquery::PlanPoint p = roadquery::evaluate(e, ds);
  const double t = roadquery::evaluate(offset, e.s + ds), slope = roadquery::derivative(offset, e.s + ds);
  return p.hdg + std::atan2(slope, 1.0 - p.curvature * t);
}

TEST(EaseAlong, a_lane_beside_a_turn_heads_where_it_did_where_the_curvature_jumps) {
  std::size_t most_stretches = 0;
  for (const double reach_m : {10.0, 19.0, 80.0}) {
    const auto line =
        connecting_line(corner(), {{ChainIndex(0), 200.0 - reach_m, 200}, {ChainIndex(1), 0, reach_m}}, 8.0);
    const double length_m = network::plan_length(line);
    ASSERT_GT(line.size(), 1u);
    for (const auto& [from, to] : {std::pair{3.0, -2.0}, {0.0, 3.5}, {-6.0, -3.0}}) {
      const std::vector<roadquery::Cubic> offset = network::ease_along(line, from, to);
      for (const auto& [s, value] : {std::pair{0.0, from}, {length_m, to}}) {
        EXPECT_NEAR(roadquery::evaluate(offset, s), value, 1e-9);
        EXPECT_NEAR(roadquery::derivative(offset, s), 0.0, 1e-9);
      }
      most_stretches = std::max(most_stretches, offset.size());
      double sharpest_change = 0.0, gentlest_change = INFINITY;
      for (const roadquery::Cubic& c : offset) {
        sharpest_change = std::max(sharpest_change, std::abs(c.c));
        gentlest_change = std::min(gentlest_change, std::abs(c.c));
      }
      EXPECT_NEAR(gentlest_change, sharpest_change, 1e-9);
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const double before = heading_beside(line, offset, i, line[i].length - 1e-7);
        const double after = heading_beside(line, offset, i + 1, 1e-7);
        EXPECT_LT(std::abs(std::remainder(after - before, 2.0 * std::numbers::pi)), 1e-5) << reach_m << ' ' << i;
      }
    }
  }
  EXPECT_EQ(most_stretches, 3u) << "the case that is tested: straight, turn, straight";
}

TEST(EaseAlong, one_value_is_one_cubic) {
  const auto line = connecting_line(corner(), {{ChainIndex(0), 181, 200}, {ChainIndex(1), 0, 19}}, 8.0);
  const std::vector<roadquery::Cubic> offset = network::ease_along(line, 2.5, 2.5);
  ASSERT_EQ(offset.size(), 1u);
  EXPECT_EQ(roadquery::evaluate(offset, 7.0), 2.5);
}

}  // namespace
}  // namespace orthodrive::network_test
