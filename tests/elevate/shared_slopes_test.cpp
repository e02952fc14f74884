// SPDX-License-Identifier: Apache-2.0
// Roads that share pavement are one surface there, though each has a height and a designed cross slope of its own.
#include "orthodrive/elevate/banking/shared_slopes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "orthodrive/elevate/elevate_roads.hpp"
#include "test_roads.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double slip_slope = 0.05;  // across, per metre along
constexpr double half_width_m = 3.0;

/// A one-way road eastwards, and one that leaves it at x = 100 to one side.
RoadNetwork one_way_fork(double side, const std::string& main, const std::string& slip) {
  RoadNetwork roads{test::road_crs, {}};
  roads.paths.push_back(test::straight_road(1, {0.0, 0.0}, {100.0, 0.0}, 10, 20));
  roads.paths.push_back(test::straight_road(1, {100.0, 0.0}, {300.0, 0.0}, 20, 30));
  roads.paths.push_back(test::straight_road(2, {100.0, 0.0}, {300.0, side * 200.0 * slip_slope}, 20, 40));
  for (RoadPath& path : roads.paths) path.oneway = Oneway::forward, path.highway = main;
  roads.paths.back().highway = slip;
  return roads;
}

/// Terrain too coarse to show banking.
HeightGrid coarse_slope(double northwards) {
  return test::terrain_grid([&](double, double y) { return 20.0 + northwards * y; }, 10.0);
}

double surface_m(const RoadNode& node, double y, double forward) {
  const double left_m = forward * (y - node.p.y);
  return node.z_m + left_m * std::tan(node.banking) - std::abs(left_m) * std::tan(node.crown);
}

/// Largest step between both surfaces in the middle of the strip that they share, from where the slip road is
/// `from_m` aside until their edges part.
double largest_step_m(const RoadPath& main, const RoadPath& slip, double from_m, double forward = 1.0) {
  double largest_m = 0.0;
  for (const RoadNode& node : slip.nodes) {
    if (std::abs(node.p.y) < from_m || std::abs(node.p.y) > 2.0 * half_width_m) continue;
    const auto beside =
        std::ranges::min_element(main.nodes, {}, [&](const RoadNode& other) { return std::abs(other.p.x - node.p.x); });
    const double y = 0.5 * node.p.y;  // both are as wide
    largest_m = std::max(largest_m, std::abs(surface_m(*beside, y, forward) - surface_m(node, y, forward)));
  }
  return largest_m;
}

TEST(SharedSlopes, LaySurfacesOnEachOtherOnSlopesToEitherSide) {
  for (const auto& [main, slip] : {std::pair{"primary", "primary_link"}, {"residential", "residential"}})
    for (const double side : {1.0, -1.0})
      for (const double northwards : {-0.04, -0.02, 0.0, 0.02, 0.04}) {
        const RoadNetwork roads = elevate_roads(one_way_fork(side, main, slip), {coarse_slope(northwards)}, {}).roads;
        EXPECT_LT(largest_step_m(roads.paths[1], roads.paths[2], 2.5), 0.02)
            << main << " " << side << " " << northwards;
      }
}

/// The same roads coming together.
TEST(SharedSlopes, HoldForRoadsThatMerge) {
  RoadNetwork fork = one_way_fork(1.0, "primary", "primary_link");
  for (RoadPath& path : fork.paths) {
    std::ranges::reverse(path.nodes);
    const double length_m = path.nodes.front().s_m;
    for (RoadNode& node : path.nodes) node.s_m = length_m - node.s_m;
  }
  const RoadNetwork roads = elevate_roads(fork, {coarse_slope(-0.04)}, {}).roads;
  EXPECT_LT(largest_step_m(roads.paths[1], roads.paths[2], 2.5, -1.0), 0.02);
}

/// Where the edges have parted by 3 m the slip road turns to the slope that it has by itself.
TEST(SharedSlopes, LeaveWhatIsFarApart) {
  const RoadNetwork fork = one_way_fork(1.0, "primary", "primary_link");
  RoadNetwork alone = fork;
  alone.paths.erase(alone.paths.begin(), alone.paths.begin() + 2);
  const RoadPath beside = elevate_roads(fork, {coarse_slope(-0.04)}, {}).roads.paths[2],
                 by_itself = elevate_roads(alone, {coarse_slope(-0.04)}, {}).roads.paths[0];
  EXPECT_NEAR(std::tan(beside.nodes.back().banking), std::tan(by_itself.nodes.back().banking), 0.008);
  EXPECT_GT(std::abs(std::tan(beside.nodes[40].banking) - std::tan(by_itself.nodes[40].banking)), 0.02) << "4 m aside";
}

/// One place of two roads 5 m apart, the other one `rise_m` higher.
std::vector<std::vector<BankingAnchor>> shared_at_one_place(double rise_m, BankingSource source) {
  NetworkStations network;
  network.chains.resize(2), network.of_node.resize(2);
  std::vector<BankingFit> fits(2);
  for (std::size_t k : {0U, 1U}) {
    const double along = static_cast<double>(k);
    network.chains[k].stations.push_back(
        {.p = {0.0, 5.0 * along}, .along = {1.0, 0.0}, .half_width_m = half_width_m, .z_m = rise_m * along, .path = k});
    network.of_node[k].push_back({k, 0, 1.0});
    fits[k] = {{0.025}, {0.0}, {0.02}, {source}};
  }
  const SharedPavement place{.main_chain = 0, .other_chain = 1, .left_m = 5.0, .main_path = 0, .other_path = 1};
  return share_slopes(network, {place}, fits, 0.08);
}

TEST(SharedSlopes, KeepMeasuredOnesThoseOfTwoSurfacesAndOnesThatFit) {
  const auto is_empty = [](const std::vector<BankingAnchor>& anchors) { return anchors.empty(); };
  EXPECT_TRUE(std::ranges::all_of(shared_at_one_place(-0.2, BankingSource::dtm), is_empty));
  EXPECT_TRUE(std::ranges::all_of(shared_at_one_place(-0.2, BankingSource::none), is_empty));
  EXPECT_TRUE(std::ranges::all_of(shared_at_one_place(-1.0, BankingSource::design), is_empty)) << "20 % across";
  EXPECT_TRUE(std::ranges::all_of(shared_at_one_place(5.0 * 0.025, BankingSource::design), is_empty)) << "one plane";
  const std::vector<std::vector<BankingAnchor>> both = shared_at_one_place(-0.2, BankingSource::design);
  ASSERT_EQ(both[0].size(), 1U);
  ASSERT_EQ(both[1].size(), 1U);
  EXPECT_NEAR(both[0][0].slope, -0.04, 0.003) << "the plane through both";
  EXPECT_NEAR(both[1][0].slope, -0.04, 0.003);
}

}  // namespace
}  // namespace orthodrive::elevate
