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

}  // namespace orthodrive
