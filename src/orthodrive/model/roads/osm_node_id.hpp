// SPDX-License-Identifier: Apache-2.0
#pragma once
// Whether a node of a path is one of the map (RoadNode::osm_node).

#include <cstdint>

namespace orthodrive {

/// The value of an osm_node that is none: a node put in by resampling, or where the border of the area cuts a way.
constexpr std::int64_t no_osm_node = 0;

/// Ids of OSM are never 0, and new objects of editors have negative ones. Paths that share such an id meet there.
[[nodiscard]] constexpr bool is_osm_node(std::int64_t osm_node) { return osm_node != no_osm_node; }

}  // namespace orthodrive
