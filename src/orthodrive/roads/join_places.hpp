// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that meet in one place without a common node: data that was a shapefile, and near misses of mappers.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Nodes within 2 cm of each other become one: that of the first path. Paths of two layers stay apart unless both end
/// there, as a bridge does at its abutment. Finding "osm.nodes_in_one_place" for each place.
///
/// Then ends that no other path shares and that lie on the carriageway of a path of the same level (layer, bridge and
/// tunnel) join it: they move onto its centre line, to a node within 1 m or a new one with the id of the end. Finding
/// "osm.end_joined". Ends beside a road that runs nearly parallel stay and are told as "osm.end_on_road": which of both
/// is wrong, the map does not say. Ends that the border of the area cut have no id and stay.
///
/// Signs and turn restrictions follow the nodes. The result does not depend on the ids of nodes. O(n log n).
void join_places(RoadNetwork& roads, Findings& findings);

}  // namespace orthodrive
