// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads between two junctions that are too short for arms of their own.

#include <array>
#include <cstddef>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Roads one after another from a junction to a junction that are together no longer than the two lengths over which
/// surfaces turn into arms (2 * junction_transition_m). The surfaces of both junctions cover them: none turns into
/// them.
struct ShortWay {
  std::vector<std::size_t> roads;     ///< indices in RoadMap::roads, in order
  std::array<int, 2> junctions = {};  ///< ids at its ends; may be the same
};

/// Each once, by the index of the first road.
[[nodiscard]] std::vector<ShortWay> short_ways(const RoadMap& map);

}  // namespace roadquery
