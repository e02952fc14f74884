// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a stage tells about its least-squares solve.

namespace orthodrive {

struct SolveSummary {
  bool converged = true;  ///< all parts of the problem reached the tolerance; not converging is an answer, not an error
  int iterations = 0;     ///< largest number over the parts that are solved one by one
  double cost_before = 0.0;  ///< half the sum of squared (robustified) residuals, summed over the parts
  double cost_after = 0.0;
};

}  // namespace orthodrive
