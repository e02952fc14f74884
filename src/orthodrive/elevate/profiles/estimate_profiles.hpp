// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights and gradients of road paths from terrain models: the whole network as smooth profiles (docs/elevate.md), and
// the methods of "From Aerial Images to Virtual Driving Environments" (2016), sec. 3.4, to compare with.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/model/roads/height_control.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive {

enum class HeightMethod {
  network,         ///< all roads at once: C2 profiles, tangent planes at junctions, limits of the road class, bridges
  reference,       ///< sec. 3.4.2 as published: way by way, w_g 1.2, w_v 12, w_e 0.2, Cauchy loss
  moving_average,  ///< way by way over `window` samples, as the reference's table 3.6; 1 is the terrain as sampled
};

struct ElevateOptions {
  HeightMethod method = HeightMethod::network;
  HeightSampling sampling = HeightSampling::cubic;
  int window = 35;           ///< samples of the moving average, odd
  double loss_m = 0.5;       ///< scale of the reference's Cauchy loss (baselines/reference_heights.hpp)
  double clearance_m = 4.7;  ///< of a bridge's surface over the road below, of a road over a tunnel's surface
  int max_iterations = 50;   ///< of each solve
  std::vector<HeightControlPoint> control_points;  ///< in the roads' CRS; network only (throws OptionError)
  int threads = 0;                                 ///< 0 = all cores; the result does not depend on it
};

/// Means over the nodes where the terrain is the road: it has a height there, and there is no bridge or tunnel.
struct ProfileEnergy {
  double gradient = 0.0;         ///< E_RG, eq. 3.13: mean squared gradient of the segments
  double height_error_m2 = 0.0;  ///< E_h, eq. 3.12: mean squared difference to the terrain
};

struct EstimateProfilesResult {
  RoadNetwork roads;  ///< z_m, gradient and (network only) sigma_z_m of every node; banking as it came
  SolveSummary solve;
  ProfileEnergy before, after;  ///< of the sampled terrain and of the result
  /// Robust standard deviation of the terrain models about the roads, as given; 0 where a model is not used. Network
  /// only.
  std::vector<double> terrain_sigma_m;
  /// "elevate.no_terrain", "elevate.implausible_terrain", "elevate.not_converged"; of the network method also
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
