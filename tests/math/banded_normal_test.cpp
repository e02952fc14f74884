// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/banded_normal.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/math/normal_matrix.hpp"

namespace orthodrive {
namespace {

TEST(BandedNormal, solves_and_its_variances_agree_with_the_sparse_ones) {
  Random random(7);
  constexpr std::size_t n = 60;
  BandedNormal normal(n, 4);
  SparseJacobian jacobian{.columns = static_cast<int>(n), .row_start = {0}};
  std::vector<double> truth(n);
  for (double& x : truth) x = random.normal();
  for (std::size_t i = 0; i + 4 < n + 3; ++i) {
    const std::size_t a = std::min(i, n - 1), b = std::min(i + 4, n - 1) == a ? a - 3 : std::min(i + 4, n - 1);
    for (int repeat = 0; repeat < 2; ++repeat) {
      const std::array index{a, b};
      const std::array coefficients{random.normal() + 2.0, random.normal()};
      const double weight = random.uniform(0.5, 2.0);
      normal.add(index, coefficients, coefficients[0] * truth[a] + coefficients[1] * truth[b], weight);
      for (int k : {0, 1}) {
        jacobian.column.push_back(static_cast<int>(index[k]));
        jacobian.value.push_back(std::sqrt(weight) * coefficients[k]);
      }
      jacobian.row_start.push_back(static_cast<int>(jacobian.column.size()));
    }
  }
  const auto solution = normal.solve(true);
  const auto variance = inverse_normal_diagonal(jacobian);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_NEAR(solution.x[i], truth[i], 1e-9) << i;  // exact data: whatever the weights
    EXPECT_NEAR(solution.variance[i], variance[i], 1e-9 * variance[i]) << i;
  }
}

TEST(BandedNormal, weights_are_inverse_variances) {
  BandedNormal normal(1, 0);
  const std::array<std::size_t, 1> index{0};
  const std::array one{1.0};
  normal.add(index, one, 3.0, 1.0 / 0.04);
  normal.add(index, one, 6.0, 2.0 / 0.04);
  const auto solution = normal.solve(true);
  EXPECT_NEAR(solution.x[0], 5.0, 1e-12);
  EXPECT_NEAR(solution.variance[0], 0.04 / 3.0, 1e-12);
}

TEST(BandedNormal, undetermined_unknowns_are_refused) {
  EXPECT_THROW((void)BandedNormal(2, 1).solve(), Error);
  EXPECT_TRUE(BandedNormal(0, 3).solve(true).x.empty());
}

}  // namespace
}  // namespace orthodrive
