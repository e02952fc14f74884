// SPDX-License-Identifier: Apache-2.0
#pragma once
// Places where roads meet: what arrives at each, and in which direction.

#include <cstdint>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/roads/path_links.hpp"

namespace orthodrive {

/// A visit of a path at a junction: a node inside it, or one of its ends.
struct JunctionArm {
  std::size_t path = 0, node = 0;
  Vec2 direction;  ///< unit vector along the path there; where the path goes on in another, that of both together
};

struct PathJunction {
  std::int64_t osm_node = 0;
  Vec2 p;
  std::vector<JunctionArm> arms;  ///< ordered by path, then node
};

/// All osm_nodes where at least two roads come together, ordered by id. A road is a path with those it is linked to:
/// where one way goes on in the next and nothing else arrives there is no junction.
[[nodiscard]] std::vector<PathJunction> find_junctions(const RoadNetwork& roads, const PathLinks& links);

}  // namespace orthodrive
