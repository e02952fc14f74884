// SPDX-License-Identifier: Apache-2.0
#pragma once
// A first guess for the nonlinear fit: the best offsets and widths of a coarse grid, found exactly by dynamic
// programming (level_search.hpp).

#include <vector>

#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/refine_roads.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

/// Offset and width of every node of a chain, in metres.
struct ChainShape {
  std::vector<double> offset_m, width_m;
};
template <typename Archive>
void fields(Archive& archive, ChainShape& shape) {
  archive(shape.offset_m, shape.width_m);
}

/// How much less than usually the input says of a node's width, >= 1.
[[nodiscard]] double looseness(const ChainNode& node);
/// Upper bound of a node's width, times the input's: options.max_width_factor, and up to 2.5 where the input says
/// little.
[[nodiscard]] double max_width_factor(const ChainNode& node, const RefineRoadsOptions& options);

/// Offsets in steps of 0.5 m up to the search radius, widths in 13 levels between the smallest and the largest factor;
/// from segment to segment each changes by one level at most. The cost of a segment is the misclassified width in
/// metres: non-road inside the road, road in a strip of 2 m beside it; plus a weak pull to the input's width and to the
/// expected offset of each node (empty: 0). The levels are averaged over 9 nodes.
[[nodiscard]] ChainShape search_offsets(const RoadChain& chain, const CrossProfiles& profiles,
                                        const std::vector<ExpectedOffset>& expected, const RefineRoadsOptions& options);

}  // namespace orthodrive::refine
