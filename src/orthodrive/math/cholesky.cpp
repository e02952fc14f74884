// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/cholesky.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {

bool factorize(const SymmetricMatrix& a, LeastPivot least) {
  for (std::size_t i = 0; i < a.size; ++i) {
    const std::size_t first = i > a.band ? i - a.band : 0;
    for (std::size_t k = first; k < i; ++k) {
      double sum = a(i, k);
      for (std::size_t m = std::max(first, k > a.band ? k - a.band : 0); m < k; ++m) sum -= a(i, m) * a(k, m);
      a(i, k) = sum / a(k, k);
    }
    double pivot = a(i, i);
    for (std::size_t m = first; m < i; ++m) pivot -= a(i, m) * a(i, m);
    if (!(pivot > least.absolute + least.relative * a(i, i))) return false;
    a(i, i) = std::sqrt(pivot);
  }
  return true;
}

void solve_factored(const SymmetricMatrix& l, std::span<double> b) {
  for (std::size_t i = 0; i < l.size; ++i) {
    for (std::size_t m = i > l.band ? i - l.band : 0; m < i; ++m) b[i] -= l(i, m) * b[m];
    b[i] /= l(i, i);
  }
  for (std::size_t i = l.size; i-- > 0;) {
    for (std::size_t m = i + 1; m < std::min(l.size, i + l.band + 1); ++m) b[i] -= l(m, i) * b[m];
    b[i] /= l(i, i);
  }
}

}  // namespace orthodrive
