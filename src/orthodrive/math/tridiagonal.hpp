// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tridiagonal equations, which may go round in a circle.

#include <vector>

namespace orthodrive {

/// below x[i - 1] + diagonal x[i] + above x[i + 1] = right
struct TridiagonalRow {
  double below = 0.0, diagonal = 0.0, above = 0.0, right = 0.0;
};

/// Thomas' algorithm without pivoting, for rows that are diagonally dominant or nearly so. `cyclic`: the first row's
/// `below` stands before the last unknown and the last row's `above` before the first (Sherman and Morrison's formula);
/// otherwise both must be 0. Needs a row, two of them for cyclic ones.
[[nodiscard]] std::vector<double> solve_tridiagonal(std::vector<TridiagonalRow> rows, bool cyclic = false);

}  // namespace orthodrive
