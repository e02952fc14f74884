// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights of the nodes of roads, beside the roads.

#include <vector>

#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive {

/// [path][node], m
using NodeHeights = std::vector<std::vector<double>>;

/// Heights, and how the solve that found them went.
struct SolvedHeights {
  NodeHeights z_m;
  SolveSummary solve;
};

}  // namespace orthodrive
