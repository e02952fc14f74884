#include "orthodrive/core/banded_normal.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "orthodrive/core/error.hpp"

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
      normal_[at(index[a], index[b])] += scaled * coefficients[b];
    }
  }
}

BandedNormal::Solution BandedNormal::solve(bool with_variances) const {
  const std::size_t n = unknowns_, w = bandwidth_;
  Solution solution{right_, {}};
  std::vector<double> factor = normal_;  // becomes L of L L^T
  std::vector<double>& x = solution.x;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t first = i > w ? i - w : 0;
    for (std::size_t k = first; k <= i; ++k) {
      double sum = factor[at(i, k)];
      for (std::size_t m = std::max(first, k > w ? k - w : 0); m < k; ++m) sum -= factor[at(i, m)] * factor[at(k, m)];
      if (k < i) {
        factor[at(i, k)] = sum / factor[at(k, k)];
      } else {
        if (!(sum > 1e-14 * normal_[at(i, i)]))
          throw Error("the normal matrix is not positive definite: a parameter is not determined");
        factor[at(i, i)] = std::sqrt(sum);
      }
    }
    for (std::size_t m = first; m < i; ++m) x[i] -= factor[at(i, m)] * x[m];
    x[i] /= factor[at(i, i)];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t m = i + 1; m < std::min(n, i + w + 1); ++m) x[i] -= factor[at(m, i)] * x[m];
    x[i] /= factor[at(i, i)];
  }
  if (!with_variances) return solution;

  std::vector<double> inverse(factor.size(), 0.0);  // of the normal matrix, inside the band
  for (std::size_t c = n; c-- > 0;) {
    const std::size_t last = std::min(n, c + w + 1);
    const double pivot = factor[at(c, c)];
    for (std::size_t a = last; a-- > c;) {  // the diagonal comes last: it needs the others
      double sum = a == c ? -1.0 / pivot : 0.0;
      for (std::size_t b = c + 1; b < last; ++b) sum += factor[at(b, c)] * inverse[at(std::max(a, b), std::min(a, b))];
      inverse[at(a, c)] = -sum / pivot;
    }
  }
  solution.variance.resize(n);
  for (std::size_t i = 0; i < n; ++i) solution.variance[i] = inverse[at(i, i)];
  return solution;
}

}  // namespace orthodrive
