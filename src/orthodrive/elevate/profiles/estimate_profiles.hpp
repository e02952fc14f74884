// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights and gradients of road paths from terrain models: all roads at once, as C2 profiles with tangent planes at
// junctions, the limits of the road classes, and bridges (docs/elevate.md).

#include <functional>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/model/roads/height_control.hpp"
#include "orthodrive/model/roads/node_heights.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive {

struct ElevateOptions {
  HeightSampling sampling = HeightSampling::cubic;
  double clearance_m = 4.7;  ///< of a bridge's surface over the road below, of a road over a tunnel's surface
  int max_iterations = 50;   ///< of each solve
  std::vector<HeightControlPoint> control_points;  ///< in the roads' CRS
  /// Another method to compare with: heights of the roads from those of the terrain at their nodes. It knows neither
  /// control points (throws OptionError) nor clearances.
  std::function<SolvedHeights(const RoadNetwork& roads, const NodeHeights& terrain_m)> instead;
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
};

/// Means over the nodes where the terrain is the road: it has a height there, and there is no bridge or tunnel.
struct ProfileEnergy {
  double gradient = 0.0;         ///< E_RG, eq. 3.13: mean squared gradient of the segments
  double height_error_m2 = 0.0;  ///< E_h, eq. 3.12: mean squared difference to the terrain
};

struct EstimateProfilesResult {
  RoadNetwork roads;  ///< z_m, gradient and (not by `instead`) sigma_z_m of every node; banking as it came
  SolveSummary solve;
  ProfileEnergy before, after;  ///< of the sampled terrain and of the result
  /// Robust standard deviation of the terrain models about the roads, as given; 0 where a model is not used. Empty
  /// by `instead`.
  std::vector<double> terrain_sigma_m;
  /// "elevate.no_terrain", "elevate.implausible_terrain", "elevate.not_converged"; not by `instead` also
  /// "elevate.gradient_over_limit", "elevate.curvature_over_limit", "elevate.off_terrain", "elevate.low_clearance",
  /// "elevate.assumed_bridge", "elevate.missing_junction", "elevate.contradicting_tags", and those of control points
  /// (control_heights.hpp)
  Findings findings;
};

/// Terrain models share the roads' CRS (throws OptionError), best first: a node takes the first one that has a height
/// there. Throws OptionError when there is none at all on the whole network.
[[nodiscard]] EstimateProfilesResult estimate_profiles(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms,
                                                       const ElevateOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
