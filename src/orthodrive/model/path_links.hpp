#pragma once
// Which ways continue each other: the same road, cut by OSM where a tag changes or at a junction.

#include <map>
#include <vector>

#include "orthodrive/model/road_network.hpp"

namespace orthodrive {

struct PathEnd {
  std::size_t path = 0;
  bool at_back = false;  ///< the last node of the path instead of its first
  friend auto operator<=>(const PathEnd&, const PathEnd&) = default;
};

/// Pairs of ends at one osm_node, entered both ways round. Two ends alone at a node always continue each other unless they
/// turn back by more than 100 degrees; at junctions the straightest pairs do (up to 50 degrees, same name and class first).
/// A closed way may continue itself.
using PathLinks = std::map<PathEnd, PathEnd>;
[[nodiscard]] PathLinks link_path_ends(const RoadNetwork& roads);

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
/// Every path is in exactly one chain; chains are ordered by their lowest path, which they run along in its direction.
[[nodiscard]] std::vector<PathChain> chain_paths(const RoadNetwork& roads, const PathLinks& links);

}  // namespace orthodrive
