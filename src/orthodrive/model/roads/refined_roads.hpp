// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every method of refinement gives: the default of refine/ and the baselines.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive {

struct RefinedRoads {
  /// The input's paths, resampled; p, osm_node, s_m, offset_m, width_m and the sigmas are set. After them the paths
  /// that only GPS traces know, with negative osm_id; where they meet a way it has a node with an id.
  RoadNetwork roads;
  SolveSummary solve;
  /// "refine.no_road_seen", "refine.not_converged", "refine.self_crossing", "refine.path_from_gpx",
  /// "refine.traces_outside"
  Findings findings;
};

}  // namespace orthodrive
