// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/cholesky.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

/// A random symmetric matrix with a strong diagonal, and the right side of a known solution.
struct Problem {
  std::size_t size, band;
  std::vector<double> full, x, right;

  Problem(std::size_t n, std::size_t w, unsigned seed) : size(n), band(w), full(n * n, 0.0), x(n), right(n, 0.0) {
    Random random(seed);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = random.normal();
      for (std::size_t k = i > w ? i - w : 0; k < i; ++k) full[i * n + k] = full[k * n + i] = random.uniform(-1.0, 1.0);
      full[i * n + i] = 2.0 * static_cast<double>(w) + 1.0;
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) right[i] += full[i * n + k] * x[k];
  }
};

TEST(Cholesky, dense_and_banded_find_the_known_solution_and_agree_bit_by_bit) {
  for (const auto& [size, band] :
       {std::pair<std::size_t, std::size_t>{1, 0}, {2, 1}, {5, 4}, {40, 1}, {40, 3}, {30, 12}}) {
    const Problem problem(size, band, static_cast<unsigned>(size + band));
    std::vector<double> rows = problem.full, dense_x = problem.right;
    const SymmetricMatrix dense = SymmetricMatrix::dense(rows.data(), size, size);
    ASSERT_TRUE(factorize(dense));
    solve_factored(dense, dense_x);
    for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(dense_x[i], problem.x[i], 1e-12) << size << ' ' << band;

    std::vector<double> entries(size * (band + 1), 0.0), banded_x = problem.right;
    const SymmetricMatrix banded = SymmetricMatrix::banded(entries, band);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t k = i > band ? i - band : 0; k <= i; ++k) banded(i, k) = problem.full[i * size + k];
    ASSERT_TRUE(factorize(banded));
    solve_factored(banded, banded_x);
    EXPECT_EQ(banded_x, dense_x);
  }
}

TEST(Cholesky, refuses_what_is_not_positive_definite) {
  std::vector<double> rows = {1.0, 0.0, 2.0, 1.0};  // eigenvalues 3 and -1
  EXPECT_FALSE(factorize(SymmetricMatrix::dense(rows.data(), 2, 2)));
  rows = {1.0, 0.0, 1.0, 1.0};  // singular
  EXPECT_FALSE(factorize(SymmetricMatrix::dense(rows.data(), 2, 2)));
  rows = {1.0, 0.0, NAN, 1.0};
  EXPECT_FALSE(factorize(SymmetricMatrix::dense(rows.data(), 2, 2)));
}

TEST(Cholesky, small_pivots_count_as_undetermined_where_asked) {
  const auto fits = [](LeastPivot least) {
    std::vector<double> rows = {1.0, 0.0, 1.0, 1.0 + 1e-8};
    return factorize(SymmetricMatrix::dense(rows.data(), 2, 2), least);
  };
  EXPECT_TRUE(fits({}));
  EXPECT_FALSE(fits({.absolute = 1e-6}));
  EXPECT_FALSE(fits({.relative = 1e-6}));
  EXPECT_TRUE(fits({.relative = 1e-10}));
}

}  // namespace
}  // namespace orthodrive
