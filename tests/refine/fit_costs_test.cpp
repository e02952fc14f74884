// SPDX-License-Identifier: Apache-2.0
// Every residual of the chain fit: its analytic derivatives against central differences, and its value by hand.

#include "orthodrive/refine/fit_costs.hpp"

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "orthodrive/core/random.hpp"

namespace orthodrive::refine {
namespace {

using Cost = std::unique_ptr<ceres::CostFunction>;
using Blocks = std::vector<std::vector<double>>;  // of unknowns

std::vector<double> residuals_of(const ceres::CostFunction& cost, const Blocks& x) {
  std::vector<const double*> pointers;
  for (const auto& block : x) pointers.push_back(block.data());
  std::vector<double> residuals(static_cast<std::size_t>(cost.num_residuals()));
  EXPECT_TRUE(cost.Evaluate(pointers.data(), residuals.data(), nullptr));
  return residuals;
}

void expect_derivatives(const Cost& cost, Blocks x, double tolerance = 1e-6) {
  const auto rows = static_cast<std::size_t>(cost->num_residuals());
  ASSERT_EQ(cost->parameter_block_sizes().size(), x.size());
  std::vector<const double*> pointers;
  std::vector<std::vector<double>> jacobians;
  std::vector<double*> jacobian_pointers;
  for (const auto& block : x) {
    pointers.push_back(block.data());
    jacobians.emplace_back(rows * block.size());
  }
  for (auto& jacobian : jacobians) jacobian_pointers.push_back(jacobian.data());
  std::vector<double> residuals(rows);
  ASSERT_TRUE(cost->Evaluate(pointers.data(), residuals.data(), jacobian_pointers.data()));
  EXPECT_EQ(residuals, residuals_of(*cost, x)) << "the same with and without derivatives";
  constexpr double h = 1e-6;
  for (std::size_t b = 0; b < x.size(); ++b)
    for (std::size_t i = 0; i < x[b].size(); ++i) {
      Blocks high = x, low = x;
      high[b][i] += h, low[b][i] -= h;
      const auto above = residuals_of(*cost, high), below = residuals_of(*cost, low);
      for (std::size_t r = 0; r < rows; ++r)
        EXPECT_NEAR(jacobians[b][r * x[b].size() + i], (above[r] - below[r]) / (2.0 * h), tolerance)
            << "residual " << r << " by unknown " << i << " of block " << b;
    }
}

/// Nodes 2 m apart along a bend, normals to the left.
std::vector<ChainNode> bend(std::size_t count) {
  std::vector<ChainNode> nodes(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double a = 0.1 * static_cast<double>(i) * (1.0 + 0.2 * static_cast<double>(i));
    nodes[i].base = {20.0 * std::sin(a), 20.0 * (1.0 - std::cos(a))};
    nodes[i].normal = {-std::sin(a), std::cos(a)};
  }
  return nodes;
}

TEST(FitCosts, angles_and_their_changes) {
  const std::vector<ChainNode> nodes = bend(4);
  const std::array<const ChainNode*, 3> three{&nodes[0], &nodes[1], &nodes[2]};
  const std::array<const ChainNode*, 4> four{&nodes[0], &nodes[1], &nodes[2], &nodes[3]};
  expect_derivatives(Cost(angle_cost(three, 10.0)), {{0.3}, {-0.2}, {0.1}});
  expect_derivatives(Cost(curvature_change_cost(four, 80.0)), {{0.3}, {-0.2}, {0.1}, {0.4}}, 1e-5);
  const Vec2 a = nodes[1].base - nodes[0].base, b = nodes[2].base - nodes[1].base;
  EXPECT_NEAR(residuals_of(*Cost(angle_cost(three, 10.0)), {{0.0}, {0.0}, {0.0}})[0],
              10.0 * std::atan2(cross(a, b), dot(a, b)), 1e-12);
}

TEST(FitCosts, differences_priors_and_limits) {
  expect_derivatives(Cost(difference_cost(25.0)), {{6.0}, {6.3}});
  EXPECT_NEAR(residuals_of(*Cost(difference_cost(25.0)), {{6.0}, {6.3}})[0], 7.5, 1e-12);
  expect_derivatives(Cost(prior_cost(6.0, 0.5)), {{7.0}});
  EXPECT_NEAR(residuals_of(*Cost(prior_cost(6.0, 0.5)), {{7.0}})[0], 2.0, 1e-12);
  for (const double side : {1.0, -1.0}) {
    // The edge at offset + side * width / 2; the limit at side * 3.
    const Cost limit(limit_cost(side, side * 3.0, 10.0));
    EXPECT_EQ(residuals_of(*limit, {{side * -0.5}, {6.0}})[0], 0.0) << "half a metre before the limit";
    EXPECT_NEAR(residuals_of(*limit, {{side * 0.25}, {6.0}})[0], 2.5, 1e-12);
    expect_derivatives(limit, {{side * 0.25}, {6.0}});
    expect_derivatives(limit, {{side * -0.5}, {6.0}});
  }
}

TEST(FitCosts, shifts_of_ways_and_errors_of_traces) {
  const Vec2 normal = normalized(Vec2{0.6, 0.9});
  expect_derivatives(Cost(shift_prior_cost(5.0)), {{0.4, -0.7}});
  expect_derivatives(Cost(node_shift_cost(normal, 0.3, 2.0)), {{0.4, -0.7}, {1.1}});
  EXPECT_NEAR(residuals_of(*Cost(node_shift_cost(normal, 0.3, 2.0)), {{0.0, 0.0}, {1.1}})[0], 1.6, 1e-12);
  expect_derivatives(Cost(trace_cost(normal, 0.8, 1.5, 2.0, 0.5)), {{1.1}, {0.2, 0.1}, {-0.3, 0.4}});
  EXPECT_NEAR(residuals_of(*Cost(trace_cost(normal, 0.8, 1.5, 2.0, 0.5)), {{1.1}, {0.0, 0.0}, {0.0, 0.0}})[0], 0.6,
              1e-12);
  expect_derivatives(Cost(trace_drift_cost(0.7)), {{0.2, 0.1}, {-0.3, 0.4}});
}

TEST(FitCosts, classification_of_the_four_strips) {
  CrossProfiles profiles{.step_m = 0.25, .half_m = 12.0, .cells = 96};
  Random random(5);
  for (std::size_t row = 0; row < rows_per_segment; ++row) {
    for (int k = 0; k < profiles.cells; ++k) {
      const double t = (k + 0.5) * profiles.step_m - profiles.half_m;
      const double road = std::clamp(0.5 + 0.4 * (3.0 - std::abs(t - 0.8)), 0.0, 1.0) * (0.9 + 0.1 * random.uniform());
      profiles.false_positive.push_back(static_cast<float>(road));
      profiles.false_negative.push_back(static_cast<float>(1.0 - road));
    }
    profiles.chain_evidence.push_back({1.0, 1.0});
    profiles.evidence.push_back(row == 0 ? EdgeEvidence{1.0, 1.0} : EdgeEvidence{0.5, 0.25});
    profiles.road_near.push_back(true);
  }
  const StripCosts strips(profiles, 1.5);
  const Cost cost(classification_cost(strips, profiles, 0, 20.0));
  expect_derivatives(cost, {{0.33}, {5.9}, {0.71}, {6.3}}, 1e-5);
  const auto square = [&](double offset, double width) {
    double sum = 0.0;
    for (const double r : residuals_of(*cost, {{offset}, {width}, {offset}, {width}})) sum += r * r;
    return sum;
  };
  EXPECT_LT(square(0.8, 6.0), square(1.8, 6.0));
  EXPECT_LT(square(0.8, 6.0), square(0.8, 8.0));
  EXPECT_LT(square(0.8, 6.0), square(0.8, 4.0));
  profiles.evidence.assign(profiles.evidence.size(), {0.0, 0.0});
  for (const double r : residuals_of(*Cost(classification_cost(strips, profiles, 0, 20.0)), {{5}, {6}, {5}, {6}}))
    EXPECT_EQ(r, 0.0) << "without evidence nothing counts";
}

}  // namespace
}  // namespace orthodrive::refine
