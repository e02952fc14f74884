// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that are a reference line alone.

#include <cstddef>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Gives every road that has no lane anywhere a driving lane of half the width on both sides of its reference line: the
/// line's profile, extruded. Returns the indices of these roads.
std::vector<std::size_t> widen_bare_roads(RoadMap& map, double width_m);

}  // namespace roadquery
