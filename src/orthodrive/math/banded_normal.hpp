// SPDX-License-Identifier: Apache-2.0
#pragma once
// Linear least squares whose unknowns lie along a line: each residual joins neighbours only, so the normal matrix is
// banded and everything is linear in the number of unknowns.

#include <cstddef>
#include <span>
#include <vector>

namespace orthodrive {

/// Minimises sum weight (coefficients . x - target)^2.
class BandedNormal {
 public:
  /// Unknowns of one residual differ by at most `bandwidth` in their index.
  BandedNormal(std::size_t unknowns, std::size_t bandwidth);

  /// Weight is 1 / variance of the target.
  void add(std::span<const std::size_t> index, std::span<const double> coefficients, double target, double weight);

  struct Solution {
    std::vector<double> x;
    std::vector<double> variance;  ///< of every unknown: diagonal of the inverse; empty unless asked for
  };
  /// By cholesky.hpp; variances by the recurrence of Takahashi, Fagan and Chen (1973) inside the band.
  /// Throws Error when the residuals leave an unknown undetermined.
  [[nodiscard]] Solution solve(bool with_variances = false) const;

 private:
  std::size_t unknowns_, bandwidth_;
  std::vector<double> normal_, right_;  // the former as SymmetricMatrix::banded has it
};

}  // namespace orthodrive
