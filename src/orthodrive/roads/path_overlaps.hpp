// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where carriageways of two layers lie above each other along their length: double decks, tunnels under streets.

#include <vector>

#include "orthodrive/roads/path_crossings.hpp"

namespace orthodrive {

struct PathOverlap {
  PathCrossing at;          ///< nearest places of both; `p` is on the upper path
  double distance_m = 0.0;  ///< between them, in plan
  bool a_is_above = false;
};

/// Every 10 m along paths of a higher layer, where their carriageway and that of a path of a lower layer overlap by
/// half a metre or more in plan while both run within 45 degrees of each other. Where the upper one is no bridge and
/// the lower one no tunnel, their middles have to be within 2 m. Steeper crossings are those of find_crossings. Ordered
/// by the upper path, place and lower path.
[[nodiscard]] std::vector<PathOverlap> find_overlaps(const RoadNetwork& roads);

}  // namespace orthodrive
