// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/math/tridiagonal.hpp"

#include <cstddef>

namespace orthodrive {

std::vector<double> solve_tridiagonal(std::vector<TridiagonalRow> rows, bool cyclic) {
  const std::size_t n = rows.size();
  double corner_first = 0.0, corner_last = 0.0;
  std::vector<double> u(n, 0.0);
  if (cyclic) {  // a tridiagonal system plus a product of two vectors
    corner_first = rows.front().below, corner_last = rows.back().above;
    const double gamma = -rows.front().diagonal;
    u.front() = gamma, u.back() = corner_last;
    rows.front().diagonal -= gamma;
    rows.back().diagonal -= corner_first * corner_last / gamma;
    corner_first /= gamma;  // from here on: last entry of the other vector (1, 0, ..., below / gamma)
  }
  for (std::size_t i = 1; i < n; ++i) {
    const double f = rows[i].below / rows[i - 1].diagonal;
    rows[i].diagonal -= f * rows[i - 1].above;
    rows[i].right -= f * rows[i - 1].right;
    u[i] -= f * u[i - 1];
  }
  std::vector<double> x(n);
  for (std::size_t i = n; i-- > 0;) {
    x[i] = (rows[i].right - (i + 1 < n ? rows[i].above * x[i + 1] : 0.0)) / rows[i].diagonal;
    u[i] = (u[i] - (i + 1 < n ? rows[i].above * u[i + 1] : 0.0)) / rows[i].diagonal;
  }
  if (cyclic) {
    const double factor = (x.front() + corner_first * x.back()) / (1.0 + u.front() + corner_first * u.back());
    for (std::size_t i = 0; i < n; ++i) x[i] -= factor * u[i];
  }
  return x;
}

}  // namespace orthodrive
