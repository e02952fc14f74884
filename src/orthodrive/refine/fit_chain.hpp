#pragma once
// The nonlinear least-squares fit of one chain: an offset and a width per node.

#include <vector>

#include "orthodrive/model/solve_summary.hpp"
#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/refine/road_chains.hpp"
#include "orthodrive/refine/search_offsets.hpp"

namespace orthodrive {

struct ChainFit {
  ChainShape shape;
  std::vector<double> sigma_offset_m, sigma_width_m;
  SolveSummary solve;
};

/// Levenberg-Marquardt from `start`. One thread, no randomness: the same result everywhere.
[[nodiscard]] ChainFit fit_chain(const RoadChain& chain, const CrossProfiles& profiles, const ChainShape& start,
                                 const RefineRoadsOptions& options);

}  // namespace orthodrive
