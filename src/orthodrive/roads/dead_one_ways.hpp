// SPDX-License-Identifier: Apache-2.0
#pragma once
// One-way roads that nobody can enter or leave: mostly a direction that is wrong in the map.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Tells of nodes where two or more one-way roads lead away and none leads there (finding "osm.no_way_in"), and the
/// reverse ("osm.no_way_out"). At the border of a map roads are missing: so it speaks only where roads lie around the
/// node, either those that meet there (none of them takes up a half-plane alone) or others within 300 m. Where a single
/// road begins or ends it says nothing: in fourteen extracts of towns 72 roads do, all of them at the border, eleven
/// with roads around them. Nothing changes. O(n log n), and O(n) for each node in question.
void report_dead_one_ways(const RoadNetwork& roads, Findings& findings);

}  // namespace orthodrive
