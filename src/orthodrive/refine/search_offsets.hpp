#pragma once
// A first guess for the nonlinear fit: the best offsets and widths of a coarse grid, found exactly by dynamic programming.

#include <vector>

#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/refine/road_chains.hpp"

namespace orthodrive {

/// Offset and width of every node of a chain, in metres.
struct ChainShape {
  std::vector<double> offset_m, width_m;
};

/// Viterbi search over offset x width with small steps between segments. The cost of a segment is the misclassified
/// width in metres: non-road inside the road, road in a strip beside it; plus a weak pull to the input's width and to the
/// expected offset of each node (empty: 0).
[[nodiscard]] ChainShape search_offsets(const RoadChain& chain, const CrossProfiles& profiles,
                                        const std::vector<ExpectedOffset>& expected, const RefineRoadsOptions& options);

}  // namespace orthodrive
