// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that the map draws more than once along the same nodes: copies of ways, ways that go back on themselves, and a
// line for each direction where data was a graph of directed edges.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Each stretch between two neighbouring nodes is there once for each level (layer, bridge and tunnel). Of two paths
/// the one of the higher class stays whole, of equal ones the one for both directions, then the first one; what the
/// other has besides becomes pieces of it with the next free numbers of `part`.
///
/// Two one-way paths along the same nodes that lead against each other become one path for both directions with the
/// lanes of both. Turn restrictions from or to a way that is gone count for the one that stays. Finding
/// "osm.drawn_twice" for each path that was cut or left out.
///
/// Wants nodes in one place to be one (join_places.hpp). O(n log n).
void draw_once(RoadNetwork& roads, Findings& findings);

}  // namespace orthodrive
