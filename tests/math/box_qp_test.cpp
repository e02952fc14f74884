// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/box_qp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

/// A program whose answer is chosen first: some unknowns on a bound with a multiplier that holds them there.
struct Program {
  std::vector<double> entries, gradient, lower, upper, answer;
  std::size_t band;

  Program(std::size_t n, std::size_t band, unsigned seed) : entries(n * (band + 1), 0.0), gradient(n, 0.0), band(band) {
    Random random(seed);
    const SymmetricMatrix h = SymmetricMatrix::banded(entries, band);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = i > band ? i - band : 0; k < i; ++k) h(i, k) = random.uniform(-1.0, 1.0);
      h(i, i) = 2.0 * static_cast<double>(band) + 1.0;
      lower.push_back(random.uniform(-2.0, -1.0)), upper.push_back(random.uniform(1.0, 2.0));
      const int where = static_cast<int>(i % 3);
      answer.push_back(where == 0 ? lower[i] : where == 1 ? upper[i] : random.uniform(-0.9, 0.9));
      gradient[i] = where == 0 ? random.uniform(0.5, 2.0) : where == 1 ? -random.uniform(0.5, 2.0) : 0.0;
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k)
        if (std::max(i, k) - std::min(i, k) <= band) gradient[i] -= h(std::max(i, k), std::min(i, k)) * answer[k];
  }
  [[nodiscard]] std::vector<double> solve() {
    return minimize_in_box(SymmetricMatrix::banded(entries, band), gradient, lower, upper);
  }
};

TEST(BoxQp, finds_the_chosen_answer_on_bounds_and_between_them) {
  for (const std::size_t n : {1u, 2u, 7u, 300u}) {
    for (const std::size_t band : {0u, 1u, 3u, 6u}) {
      if (band >= n) continue;
      Program program(n, band, static_cast<unsigned>(17 * n + band));
      const std::vector<double> x = program.solve();
      for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(x[i], program.answer[i], 1e-7) << n << " " << band << " " << i;
    }
  }
}

TEST(BoxQp, without_reachable_bounds_it_solves_the_equations) {
  std::vector<double> entries = {2.0, 4.0};
  const std::vector<double> gradient = {-2.0, 8.0}, lower = {-1e3, -1e3}, upper = {1e3, 1e3};
  const std::vector<double> x = minimize_in_box(SymmetricMatrix::banded(entries, 0), gradient, lower, upper);
  EXPECT_NEAR(x[0], 1.0, 1e-6);
  EXPECT_NEAR(x[1], -2.0, 1e-6);
}

TEST(BoxQp, matrix_of_zeros_leaves_the_gradient_to_decide) {
  std::vector<double> entries = {0.0, 0.0};
  const std::vector<double> gradient = {1.0, -1.0}, lower = {-3.0, -3.0}, upper = {5.0, 5.0};
  const std::vector<double> x = minimize_in_box(SymmetricMatrix::banded(entries, 0), gradient, lower, upper);
  EXPECT_NEAR(x[0], -3.0, 1e-6);
  EXPECT_NEAR(x[1], 5.0, 1e-6);
}

TEST(BoxQp, numbers_that_are_none_are_refused) {
  std::vector<double> entries = {1.0};
  const std::vector<double> gradient = {std::numeric_limits<double>::quiet_NaN()}, lower = {-1.0}, upper = {1.0};
  EXPECT_THROW((void)minimize_in_box(SymmetricMatrix::banded(entries, 0), gradient, lower, upper), Error);
  EXPECT_TRUE(minimize_in_box({}, {}, {}, {}).empty());
}

}  // namespace
}  // namespace orthodrive
