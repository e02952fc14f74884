// SPDX-License-Identifier: Apache-2.0
#pragma once
// Error bars of a least-squares solution: variances without the full inverse.

#include <vector>

namespace orthodrive {

/// A Jacobian in compressed rows: row i has the entries row_start[i] .. row_start[i+1].
struct SparseJacobian {
  int columns = 0;
  std::vector<int> row_start, column;
  std::vector<double> value;
};

/// (J^T J)^-1 on the pattern of the sparse Cholesky factor, by the recurrence of Takahashi, Fagan and Chen (1973):
/// linear in the size for the chain-like graphs of roads.
class InverseNormal {
 public:
  /// Throws Error when J^T J is not positive definite.
  explicit InverseNormal(const SparseJacobian& jacobian);
  /// An entry. i == k, or some row of J has both columns: others are not known (asserted).
  [[nodiscard]] double at(int i, int k) const;

 private:
  [[nodiscard]] std::size_t index_of(int low, int high) const;  // of the permuted columns
  std::vector<int> start_, row_, position_;                     // position_: permuted place of each column
  std::vector<double> value_;
};

/// Diagonal of (J^T J)^-1. Throws Error when J^T J is not positive definite.
[[nodiscard]] std::vector<double> inverse_normal_diagonal(const SparseJacobian& jacobian);

/// Variances f (J^T J)^-1 f^T of the linear functions f, one per row of `functions`. The columns of a function must
/// occur together in some row of the Jacobian (then their covariances lie on the pattern). Throws Error as the diagonal
/// does.
[[nodiscard]] std::vector<double> normal_variances(const SparseJacobian& jacobian, const SparseJacobian& functions);

/// x of the smallest |J x - right|, by the sparse Cholesky factor of J^T J. Throws Error as the diagonal does.
[[nodiscard]] std::vector<double> solve_normal(const SparseJacobian& jacobian, const std::vector<double>& right);

}  // namespace orthodrive
