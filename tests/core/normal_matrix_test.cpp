#include "orthodrive/core/normal_matrix.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

/// Diagonal of (J^T J)^-1 by Gauss-Jordan on the full matrix: slow and simple.
std::vector<double> full_inverse_diagonal(const SparseJacobian& jacobian) {
  const auto n = static_cast<std::size_t>(jacobian.columns);
  std::vector<std::vector<double>> m(n, std::vector<double>(2 * n, 0.0));
  for (std::size_t i = 0; i < n; ++i) m[i][n + i] = 1.0;
  for (std::size_t r = 0; r + 1 < jacobian.row_start.size(); ++r)
    for (int a = jacobian.row_start[r]; a < jacobian.row_start[r + 1]; ++a)
      for (int b = jacobian.row_start[r]; b < jacobian.row_start[r + 1]; ++b)
        m[jacobian.column[a]][jacobian.column[b]] += jacobian.value[a] * jacobian.value[b];
  for (std::size_t p = 0; p < n; ++p) {
    const double pivot = m[p][p];
    for (double& v : m[p]) v /= pivot;
    for (std::size_t i = 0; i < n; ++i) {
      const double factor = m[i][p];
      for (std::size_t k = 0; i != p && k < 2 * n; ++k) m[i][k] -= factor * m[p][k];
    }
  }
  std::vector<double> diagonal;
  for (std::size_t i = 0; i < n; ++i) diagonal.push_back(m[i][n + i]);
  return diagonal;
}

TEST(NormalMatrix, agrees_with_the_full_inverse) {
  Random random(3);
  SparseJacobian jacobian{.columns = 40, .row_start = {0}};
  const auto add_row = [&](std::vector<std::pair<int, double>> entries) {
    for (const auto& [column, value] : entries) jacobian.column.push_back(column), jacobian.value.push_back(value);
    jacobian.row_start.push_back(static_cast<int>(jacobian.column.size()));
  };
  for (int i = 0; i < 40; ++i) add_row({{i, random.uniform(0.2, 1.0)}});
  for (int i = 0; i + 1 < 40; ++i) add_row({{i, random.normal()}, {i + 1, random.normal()}});
  for (int k = 0; k < 8; ++k) add_row({{k, 1.0}, {39 - 2 * k, -1.0}});  // loops: the factor fills in
  const auto sparse = inverse_normal_diagonal(jacobian), full = full_inverse_diagonal(jacobian);
  for (std::size_t i = 0; i < full.size(); ++i) EXPECT_NEAR(sparse[i], full[i], 1e-9 * full[i]) << i;
}

TEST(NormalMatrix, undetermined_parameters_are_refused) {
  EXPECT_TRUE(inverse_normal_diagonal({}).empty());
  EXPECT_THROW((void)inverse_normal_diagonal({2, {0, 1}, {0}, {1.0}}), Error);
}

}  // namespace
}  // namespace orthodrive
