// SPDX-License-Identifier: Apache-2.0
#pragma once
// Block-coordinate dynamic programming: the best states of one road with all others fixed are found exactly (Viterbi),
// road after road, until the energy no longer falls.

#include <vector>

#include "orthodrive/baselines/mrf_model.hpp"
#include "orthodrive/core/monitor.hpp"

namespace orthodrive::baselines {

struct InferMrfOptions {
  int max_sweeps = 30;
  int threads =
      0;  ///< groups of roads without conflicts between them run side by side; the result does not depend on it
};

struct InferMrfResult {
  std::vector<MrfState> states;  ///< one a site
  std::vector<double> energies;  ///< before, and after every sweep over all roads: never rising
  int sweeps = 0;
  bool converged = true;  ///< false: stopped by max_sweeps
};

/// From initial_states. Open roads that keep clear of themselves are one block; closed roads and roads that run beside
/// themselves are cut into blocks, at other sites every other sweep, which are solved one after the other.
/// Time a sweep and site: offsets * widths * (offsets + widths).
[[nodiscard]] InferMrfResult infer_mrf(const MrfProblem& problem, const InferMrfOptions& options = {},
                                       Monitor* monitor = nullptr);

}  // namespace orthodrive::baselines
