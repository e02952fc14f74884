// SPDX-License-Identifier: Apache-2.0
// The dynamic programming of the offset search against all paths, one by one.

#include "orthodrive/refine/level_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "orthodrive/core/random.hpp"

namespace orthodrive::refine {
namespace {

using Costs = std::vector<std::vector<double>>;  // [segment][state]

struct Grid {
  int offsets = 1, widths = 1;
  double step_cost = 0.2;
  [[nodiscard]] int states() const { return offsets * widths; }
};

/// Infinite where two neighbours are more than a level apart.
double cost_of(const Grid& grid, const Costs& costs, const std::vector<int>& path) {
  double total = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    total += costs[i][static_cast<std::size_t>(path[i])];
    if (i == 0) continue;
    const int d = std::abs(path[i] / grid.widths - path[i - 1] / grid.widths),
              e = std::abs(path[i] % grid.widths - path[i - 1] % grid.widths);
    if (d > 1 || e > 1) return std::numeric_limits<double>::infinity();
    total += grid.step_cost * (d + e);
  }
  return total;
}

double least_cost_of_all_paths(const Grid& grid, const Costs& costs) {
  std::vector<int> path(costs.size(), 0);
  double least = std::numeric_limits<double>::infinity();
  for (;;) {  // counts through all paths as through the digits of a number
    least = std::min(least, cost_of(grid, costs, path));
    std::size_t digit = 0;
    while (digit < path.size() && ++path[digit] == grid.states()) path[digit++] = 0;
    if (digit == path.size()) return least;
  }
}

LevelSearch searched(const Grid& grid, const Costs& costs) {
  LevelSearch search(grid.offsets, grid.widths, grid.step_cost);
  for (const auto& cost : costs) search.add_segment(cost);
  return search;
}

Costs random_costs(const Grid& grid, std::size_t segments, Random& random) {
  Costs costs(segments, std::vector<double>(static_cast<std::size_t>(grid.states())));
  for (auto& segment : costs)
    for (double& cost : segment) cost = random.uniform();
  return costs;
}

TEST(LevelSearch, equals_the_best_of_all_paths) {
  Random random(3);
  for (const Grid grid : {Grid{3, 3, 0.2}, Grid{5, 2, 0.05}, Grid{1, 7, 0.3}, Grid{7, 1, 1.0}, Grid{3, 3, 0.0}})
    for (int trial = 0; trial < 10; ++trial) {
      const Costs costs = random_costs(grid, 4, random);
      const LevelSearch search = searched(grid, costs);
      const double least = least_cost_of_all_paths(grid, costs);
      EXPECT_NEAR(cost_of(grid, costs, search.cheapest()), least, 1e-12);
      EXPECT_NEAR(search.cheapest_cost(), least, 1e-12);
    }
}

TEST(LevelSearch, a_single_segment_takes_its_cheapest_state_and_a_single_state_is_taken_always) {
  EXPECT_THAT(searched({2, 2}, {{3.0, 2.0, 0.5, 4.0}}).cheapest(), testing::ElementsAre(2));
  EXPECT_THAT(searched({1, 1}, {{3.0}, {2.0}, {7.0}}).cheapest(), testing::ElementsAre(0, 0, 0));
}

TEST(LevelSearch, states_at_the_border_never_step_beyond_it) {
  // The cheap states lie in opposite corners: levels 0 and 2 in both directions, two steps apart. A row of the grid is
  // no neighbour of the next one's begin: with state numbers alone, state 2 (0, 2) would touch state 3 (1, 0).
  const Grid grid{3, 3, 0.01};
  Costs costs(3, std::vector<double>(9, 1.0));
  costs[0][2] = costs[1][3] = costs[2][2] = 0.0;
  const std::vector<int> path = searched(grid, costs).cheapest();
  EXPECT_TRUE(std::isfinite(cost_of(grid, costs, path)));
  EXPECT_NEAR(cost_of(grid, costs, path), least_cost_of_all_paths(grid, costs), 1e-12);
  EXPECT_NE(path[1], 3);
}

TEST(LevelSearch, levels_change_by_one_a_segment) {
  // The cheapest state jumps from one end of the offsets to the other: the path climbs level by level.
  const Grid grid{5, 1, 0.0};
  Costs costs(6, std::vector<double>(5, 1.0));
  for (std::size_t i = 0; i < costs.size(); ++i) costs[i][i < 3 ? 0 : 4] = 0.0;
  const std::vector<int> path = searched(grid, costs).cheapest();
  EXPECT_NEAR(cost_of(grid, costs, path), 3.0, 1e-12);  // three levels between the two have to be paid for
  for (std::size_t i = 1; i < path.size(); ++i) EXPECT_LE(std::abs(path[i] - path[i - 1]), 1);
}

TEST(LevelSearch, of_equal_paths_the_same_one_is_found) {
  const Grid grid{3, 3, 0.2};
  const Costs flat(5, std::vector<double>(9, 0.25));
  EXPECT_THAT(searched(grid, flat).cheapest(), testing::Each(0)) << "no step pays, and the first state comes first";
  Costs two = flat;
  for (auto& segment : two) segment[1] = segment[7] = 0.0;
  EXPECT_THAT(searched(grid, two).cheapest(), testing::Each(1));
}

}  // namespace
}  // namespace orthodrive::refine
