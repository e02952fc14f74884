// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/banded_normal.hpp"

#include <algorithm>
#include <cassert>

#include "orthodrive/core/error.hpp"
#include "orthodrive/math/cholesky.hpp"

namespace orthodrive {

BandedNormal::BandedNormal(std::size_t unknowns, std::size_t bandwidth)
    : unknowns_(unknowns), bandwidth_(bandwidth), normal_(unknowns * (bandwidth + 1), 0.0), right_(unknowns, 0.0) {}

void BandedNormal::add(std::span<const std::size_t> index, std::span<const double> coefficients, double target,
                       double weight) {
  for (std::size_t a = 0; a < index.size(); ++a) {
    const double scaled = weight * coefficients[a];
    right_[index[a]] += scaled * target;
    for (std::size_t b = 0; b < index.size(); ++b) {
      if (index[b] > index[a]) continue;
      assert(index[a] - index[b] <= bandwidth_);
      SymmetricMatrix::banded(normal_, bandwidth_)(index[a], index[b]) += scaled * coefficients[b];
    }
  }
}

BandedNormal::Solution BandedNormal::solve(bool with_variances) const {
  const std::size_t n = unknowns_, w = bandwidth_;
  Solution solution{right_, {}};
  std::vector<double> entries = normal_;
  const SymmetricMatrix factor = SymmetricMatrix::banded(entries, bandwidth_);
  if (!factorize(factor, {.relative = 1e-14}))
    throw Error("the normal matrix is not positive definite: a parameter is not determined");
  solve_factored(factor, solution.x);
  if (!with_variances) return solution;

  std::vector<double> inverse_entries(entries.size(), 0.0);
  const SymmetricMatrix inverse = SymmetricMatrix::banded(inverse_entries, bandwidth_);  // known inside the band
  for (std::size_t c = n; c-- > 0;) {
    const std::size_t last = std::min(n, c + w + 1);
    const double pivot = factor(c, c);
    for (std::size_t a = last; a-- > c;) {  // the diagonal comes last: it needs the others
      double sum = a == c ? -1.0 / pivot : 0.0;
      for (std::size_t b = c + 1; b < last; ++b) sum += factor(b, c) * inverse(std::max(a, b), std::min(a, b));
      inverse(a, c) = -sum / pivot;
    }
  }
  solution.variance.resize(n);
  for (std::size_t i = 0; i < n; ++i) solution.variance[i] = inverse(i, i);
  return solution;
}

}  // namespace orthodrive
