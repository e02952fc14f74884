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

/// Diagonal of (J^T J)^-1, by the recurrence of Takahashi, Fagan and Chen (1973) on the pattern of the sparse Cholesky
/// factor: linear in the size for the chain-like graphs of roads. Throws Error when J^T J is not positive definite.
[[nodiscard]] std::vector<double> inverse_normal_diagonal(const SparseJacobian& jacobian);

/// Variances f (J^T J)^-1 f^T of the linear functions f, one a row of `functions`. The columns of a function must occur
/// together in some row of the Jacobian (then their covariances lie on the pattern). Throws Error as the diagonal does.
[[nodiscard]] std::vector<double> normal_variances(const SparseJacobian& jacobian, const SparseJacobian& functions);

/// x of the smallest |J x - right|, by the sparse Cholesky factor of J^T J. Throws Error as the diagonal does.
[[nodiscard]] std::vector<double> solve_normal(const SparseJacobian& jacobian, const std::vector<double>& right);

}  // namespace orthodrive
