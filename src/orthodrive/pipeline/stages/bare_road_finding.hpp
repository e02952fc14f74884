// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is said of roads that are a reference line alone.

#include <optional>
#include <string>

#include "orthodrive/core/finding.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// Widens them (roadquery/bare_roads.hpp). The finding has the code `stage`.bare_roads and lies where the first of them
/// begins; nothing when there is none.
[[nodiscard]] std::optional<Finding> widen_bare_roads(roadquery::RoadMap& map, double width_m,
                                                      const std::string& stage);

}  // namespace orthodrive
