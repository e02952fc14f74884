// SPDX-License-Identifier: Apache-2.0
#pragma once
// Quadratic programs whose only constraints are bounds, with a banded matrix.

#include <span>
#include <vector>

#include "orthodrive/math/cholesky.hpp"

namespace orthodrive {

/// The x that minimises 1/2 x'Hx + g'x within lower <= x <= upper, and within 1e-9 of the bounds' distance of the best
/// (relative to the largest change that the bounds allow). H is positive semidefinite, banded, and is left as it is;
/// lower < upper everywhere. Primal-dual interior-point method with Mehrotra's centring (Nocedal and Wright, Numerical
/// Optimization, 2006, sec. 16.6). Throws Error when the numbers are not finite.
[[nodiscard]] std::vector<double> minimize_in_box(const SymmetricMatrix& hessian, std::span<const double> gradient,
                                                  std::span<const double> lower, std::span<const double> upper);

}  // namespace orthodrive
