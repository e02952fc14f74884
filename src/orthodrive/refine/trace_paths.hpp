// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that GPS traces show and the map lacks.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/refine/trace_offsets.hpp"

namespace orthodrive::refine {

/// The roads of `osm`, and after them the stretches of traces that are at least 50 m long, further than 20 m from every
/// road and inside the evidence, each path once: of traces within 15 m and 30 degrees of each other the longest is
/// taken. They are `track`s with a negative osm_id. Where a trace goes on to a road within 20 m the path ends in a node
/// of that road, which gets one there if it has none. Findings "refine.path_from_gpx". Loops are cut where a trace
/// comes back to itself. Time grows with the number of paths times that of points off roads.
[[nodiscard]] RoadNetwork with_paths_of_traces(const RoadNetwork& osm, const RoadEvidence& evidence,
                                               const std::vector<MovingTrace>& traces, Findings& findings);

}  // namespace orthodrive::refine
