// SPDX-License-Identifier: Apache-2.0
#pragma once
// Linear equations with a symmetric positive definite matrix, dense or banded, by Cholesky's method. Sparse ones:
// normal_matrix.hpp; tridiagonal ones that are not symmetric or go round in a circle: tridiagonal.hpp.

#include <cstddef>
#include <span>
#include <vector>

namespace orthodrive {

/// The lower triangle of a matrix, in memory of the caller's: entry (i, k) stands at first[i * stride + k]. Entries
/// further than `band` below the diagonal are 0 and not stored.
struct SymmetricMatrix {
  double* first = nullptr;
  std::size_t size = 0, band = 0, stride = 0;

  [[nodiscard]] static SymmetricMatrix dense(double* rows, std::size_t size, std::size_t stride) {
    return {rows, size, size - 1, stride};
  }
  /// Of size * (band + 1) numbers: band + 1 per row, the diagonal last.
  [[nodiscard]] static SymmetricMatrix banded(std::vector<double>& rows, std::size_t band) {
    return {rows.empty() ? nullptr : rows.data() + band, rows.size() / (band + 1), band, band};
  }
  [[nodiscard]] double& operator()(std::size_t i, std::size_t k) const { return first[i * stride + k]; }
};

/// What a pivot must exceed for its unknown to count as determined: absolute + relative * diagonal.
struct LeastPivot {
  double absolute = 0.0, relative = 0.0;
};

/// A becomes L of A = L L^T. False where a pivot is too small: A is then of no more use.
[[nodiscard]] bool factorize(const SymmetricMatrix& a, LeastPivot least = {});
/// Solves L L^T x = b, in place.
void solve_factored(const SymmetricMatrix& l, std::span<double> b);

}  // namespace orthodrive
