// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/reference_heights.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

/// One way of nodes 2 m apart.
RoadNetwork straight_way(std::size_t nodes) {
  RoadNetwork roads;
  roads.paths.emplace_back();
  for (std::size_t i = 0; i < nodes; ++i) roads.paths[0].nodes.push_back({.p = {2.0 * static_cast<double>(i), 0.0}});
  return roads;
}

TEST(MovingAverage, is_the_mean_of_the_window_and_shrinks_towards_the_ends) {
  const std::vector<double> z{0, 1, 4, 9, 16, 25, 36};
  const NodeHeights mean = moving_average(straight_way(7), {z}, 5);
  EXPECT_THAT(mean[0], testing::Pointwise(testing::DoubleEq(), {0.0, 5.0 / 3, 6.0, 11.0, 18.0, 77.0 / 3, 36.0}));
  EXPECT_EQ(moving_average(straight_way(7), {z}, 1)[0], z) << "a window of one is the terrain";
}

TEST(MovingAverage, goes_on_round_a_closed_way_and_keeps_a_slope) {
  RoadNetwork ring = straight_way(5);
  ring.paths[0].nodes.back().p = ring.paths[0].nodes.front().p;
  const NodeHeights mean = moving_average(ring, {{3, 0, 0, 0, 3}}, 3);
  EXPECT_THAT(mean[0], testing::Pointwise(testing::DoubleEq(), {1.0, 1.0, 0.0, 1.0, 1.0}));
  const NodeHeights slope = moving_average(straight_way(5), {{0, 2, 4, 6, 8}}, 35);
  EXPECT_THAT(slope[0], testing::Pointwise(testing::DoubleEq(), {0, 2, 4, 6, 8}));
}

/// Sum of the squared residuals of eq. 3.15 to 3.17 with table 3.5 and the Cauchy loss, straight from the thesis.
double energy(const std::vector<double>& z, const std::vector<double>& terrain) {
  double sum = 0.0;
  for (std::size_t n = 0; n < z.size(); ++n) {
    const double e = 0.2 * (z[n] - terrain[n]);
    sum += 0.01 * std::log(1.0 + e * e / 0.01);  // 0.5 m, of which the weight makes 0.1
    if (n + 1 < z.size()) sum += std::pow(1.2 * (z[n + 1] - z[n]) / 2.0, 2);
    if (n > 0 && n + 1 < z.size()) sum += std::pow(12.0 * ((z[n + 1] - z[n]) - (z[n] - z[n - 1])) / 2.0, 2);
  }
  return sum;
}

TEST(ReferenceHeights, are_a_minimum_of_the_published_energy) {
  std::vector<double> terrain;
  terrain.reserve(40);
  for (int i = 0; i < 40; ++i) terrain.push_back(50.0 + 0.5 * std::sin(0.4 * i) + (i == 20 ? 4.0 : 0.0));
  const SolvedHeights result = reference_heights(straight_way(40), {terrain}, {.max_iterations = 100});
  EXPECT_TRUE(result.solve.converged);
  const std::vector<double>& z = result.z_m[0];
  const double least = energy(z, terrain);
  EXPECT_LT(least, energy(terrain, terrain));
  for (std::size_t n = 0; n < z.size(); ++n)
    for (const double step : {-0.01, 0.01}) {
      std::vector<double> moved = z;
      moved[n] += step;
      EXPECT_GT(energy(moved, terrain), least) << n;
    }
  EXPECT_LT(std::abs(z[20] - z[18]), 0.5) << "the loss gives up the outlier of 4 m";
}

TEST(ReferenceHeights, ways_share_nothing_and_flat_terrain_stays) {
  RoadNetwork roads = straight_way(10);
  roads.paths.push_back(roads.paths[0]);
  const std::vector<double> flat(10, 7.0);
  std::vector<double> hill = flat;
  hill[5] = 9.0;
  const SolvedHeights both = reference_heights(roads, {flat, hill});
  EXPECT_THAT(both.z_m[0], testing::Each(testing::DoubleNear(7.0, 1e-9)));
  const SolvedHeights alone = reference_heights(straight_way(10), {hill});
  EXPECT_THAT(both.z_m[1], testing::Pointwise(testing::DoubleNear(1e-4), alone.z_m[0]));
}

}  // namespace
}  // namespace orthodrive
