// SPDX-License-Identifier: Apache-2.0
#pragma once
// The nonlinear least-squares fit of one chain: an offset and a width per node.

#include <vector>

#include "orthodrive/model/roads/solve_summary.hpp"
#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/refine/search_offsets.hpp"
#include "orthodrive/refine/seen_places.hpp"
#include "orthodrive/refine/trace_offset.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

/// Constraints by the roads around a chain, which are held fixed.
struct ChainCoupling {
  struct Meeting {  ///< the line passes through a point that it shares with other roads
    std::size_t node = 0;
    double offset_m = 0.0;  ///< of that point along the node's normal
    double sigma_m = 0.0;
  };
  struct Limit {  ///< an edge stays on its side of a line between two parallel roads
    std::size_t node = 0;
    double side = 1.0;    ///< +1: the left edge, -1: the right one
    double edge_m = 0.0;  ///< along the node's normal
  };
  std::vector<ExpectedOffset> expected;  ///< one per node, from the shift of the map around (shift_field.hpp); empty: 0
  std::vector<TraceOffset> traces;       ///< one per node, from GPS traces; empty: none
  std::vector<SeenPlace> seen;           ///< one per node, from a network that sees the map; empty: none
  std::vector<Meeting> meetings;
  std::vector<Limit> limits;
};

struct ChainFit {
  ChainShape shape;
  std::vector<double> sigma_offset_m, sigma_width_m;
  SolveSummary solve;
};
template <typename Archive>
void fields(Archive& archive, ChainFit& fit) {
  SolveSummary& solve = fit.solve;
  archive(fit.shape, fit.sigma_offset_m, fit.sigma_width_m, solve.converged, solve.iterations, solve.cost_before,
          solve.cost_after);
}

/// Minimises the sum of squared residuals of fit_costs.hpp over all offsets and widths (Levenberg-Marquardt from
/// `start`), within the bounds of the options. Standard deviations from the normal matrix. One thread, no randomness:
/// the same result everywhere. Needs two nodes at least.
[[nodiscard]] ChainFit fit_chain(const RoadChain& chain, const CrossProfiles& profiles, const ChainShape& start,
                                 const ChainCoupling& coupling, const RefineRoadsOptions& options);

}  // namespace orthodrive::refine
