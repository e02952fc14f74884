// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which ways continue each other: the same road, cut by OSM where a tag changes or at a junction.

#include <vector>

#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/roads/continuation.hpp"
#include "orthodrive/roads/walk_chains.hpp"

namespace orthodrive {

struct PathEnd {
  std::size_t path = 0;
  bool at_back = false;  ///< the last node of the path instead of its first
  friend auto operator<=>(const PathEnd&, const PathEnd&) = default;
};

/// Pairs of ends at one osm_node, entered both ways round, by the rule of continuation.hpp. A closed way may continue
/// itself.
using PathLinks = EndLinks<PathEnd>;
[[nodiscard]] PathLinks link_path_ends(const RoadNetwork& roads, const ContinuationRule& rule = way_continuation);

/// A path of a chain, run through in the chain's direction or against it.
struct ChainPath {
  std::size_t path = 0;
  bool reversed = false;
};
/// Paths that continue each other, end to end.
struct PathChain {
  std::vector<ChainPath> paths;
  bool closed = false;  ///< the last path continues in the first
};

enum class ChainOrder {
  by_lowest_path,    ///< ordered by their lowest path, which they run along in its direction
  open_chains_first  ///< each begins with the lower of its outermost paths; then closed ones by their lowest path
};
/// Every path is in exactly one chain.
[[nodiscard]] std::vector<PathChain> chain_paths(const RoadNetwork& roads, const PathLinks& links,
                                                 ChainOrder order = ChainOrder::by_lowest_path);

}  // namespace orthodrive
