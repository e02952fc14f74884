// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/normal_matrix.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

/// (J^T J)^-1 by Gauss-Jordan on the full matrix: slow and simple.
std::vector<std::vector<double>> full_inverse(const SparseJacobian& jacobian) {
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
  for (auto& row : m) row.erase(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(n));
  return m;
}

/// A chain with loops.
SparseJacobian some_jacobian() {
  Random random(3);
  SparseJacobian jacobian{.columns = 40, .row_start = {0}};
  const auto add_row = [&](const std::vector<std::pair<int, double>>& entries) {
    for (const auto& [column, value] : entries) jacobian.column.push_back(column), jacobian.value.push_back(value);
    jacobian.row_start.push_back(static_cast<int>(jacobian.column.size()));
  };
  for (int i = 0; i < 40; ++i) add_row({{i, random.uniform(0.2, 1.0)}});
  for (int i = 0; i + 1 < 40; ++i) add_row({{i, random.normal()}, {i + 1, random.normal()}});
  for (int k = 0; k < 8; ++k) add_row({{k, 1.0}, {39 - 2 * k, -1.0}});  // loops: the factor fills in
  return jacobian;
}

TEST(NormalMatrix, agrees_with_the_full_inverse) {
  const SparseJacobian jacobian = some_jacobian();
  const auto sparse = inverse_normal_diagonal(jacobian);
  const auto full = full_inverse(jacobian);
  for (std::size_t i = 0; i < full.size(); ++i) EXPECT_NEAR(sparse[i], full[i][i], 1e-9 * full[i][i]) << i;
}

TEST(NormalMatrix, variances_of_functions_count_covariances) {
  const SparseJacobian jacobian = some_jacobian();
  const auto full = full_inverse(jacobian);
  SparseJacobian functions{.columns = 40, .row_start = {0}};
  for (int i = 0; i + 1 < 40; ++i) {
    functions.column.insert(functions.column.end(), {i, i + 1}),
        functions.value.insert(functions.value.end(), {0.7, -1.3});
    functions.row_start.push_back(2 * (i + 1));
  }
  const auto variances = normal_variances(jacobian, functions);
  for (std::size_t i = 0; i + 1 < 40; ++i) {
    const double expected = 0.49 * full[i][i] + 1.69 * full[i + 1][i + 1] - 2.0 * 0.91 * full[i][i + 1];
    EXPECT_NEAR(variances[i], expected, 1e-9 * expected) << i;
  }
}

TEST(NormalMatrix, the_solution_leaves_no_residual_in_any_parameter) {
  const SparseJacobian jacobian = some_jacobian();
  Random random(8);
  std::vector<double> right(jacobian.row_start.size() - 1);
  for (double& v : right) v = random.normal();
  const auto x = solve_normal(jacobian, right);
  std::vector<double> slope(40, 0.0);  // J^T (J x - right)
  for (std::size_t r = 0; r < right.size(); ++r) {
    double residual = -right[r];
    for (int k = jacobian.row_start[r]; k < jacobian.row_start[r + 1]; ++k)
      residual += jacobian.value[k] * x[jacobian.column[k]];
    for (int k = jacobian.row_start[r]; k < jacobian.row_start[r + 1]; ++k)
      slope[jacobian.column[k]] += jacobian.value[k] * residual;
  }
  for (const double v : slope) EXPECT_NEAR(v, 0.0, 1e-9);
}

TEST(NormalMatrix, undetermined_parameters_are_refused) {
  EXPECT_TRUE(inverse_normal_diagonal({}).empty());
  EXPECT_THROW((void)inverse_normal_diagonal({2, {0, 1}, {0}, {1.0}}), Error);
  EXPECT_THROW((void)solve_normal({2, {0, 1}, {0}, {1.0}}, {1.0}), Error);
}

}  // namespace
}  // namespace orthodrive
