// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bridges and tunnels (1.7, 13.11 and 13.12): parts of roads, as long as a road or shorter.

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Puts a road's bridges and tunnels in order within the road, and says in `bridge` and `tunnel` which of them is as
/// long as the road, to half a metre or a twentieth.
void finish_structures(Road& road);

/// Whether a place of the road is on a bridge or in a tunnel.
[[nodiscard]] bool is_on_structure(const Road& road, double s);

/// The same roads, those with a bridge or tunnel along a part of them cut at its ends, so that each is one or is none.
/// Pieces behind the first have numbers that no road or junction has; surfaces are those of the map. Roads in junctions
/// and roads with OpenCRG files stay whole: they are what most of them is.
[[nodiscard]] RoadMap cut_at_structures(RoadMap map);

}  // namespace roadquery
