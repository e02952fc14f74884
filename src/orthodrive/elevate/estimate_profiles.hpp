#pragma once
// Heights and gradients of road paths from terrain models.
//
// After "From Aerial Images to Virtual Driving Environments" (2016), sec. 3.4: height per node; residuals for the
// gradient, its change and the difference to the terrain under a Cauchy loss. What differs and why: docs/roads.md.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters.hpp"
#include "orthodrive/model/road_network.hpp"
#include "orthodrive/model/sample_height.hpp"
#include "orthodrive/model/solve_summary.hpp"

namespace orthodrive {

struct ElevateOptions {
  HeightSampling sampling = HeightSampling::cubic;
  double weight_gradient = 0.2;         ///< w_g; the reference's 1.2 pulls the ends of roads on slopes flat (docs/roads.md)
  double weight_gradient_change = 12.0; ///< w_v
  double weight_height = 0.2;           ///< w_e, 1/m
  double cauchy_scale = 0.5;            ///< of the loss on the weighted height residual
  double clearance_m = 4.7;             ///< of a bridge's surface over the road below, of a road over a tunnel's surface
  int max_iterations = 50;
  int threads = 0;                      ///< 0 = all cores; the result does not depend on it
};

/// Means over the nodes where the terrain is the road: it has a height there, and there is no bridge or tunnel
/// (eq. 3.12 and 3.13 of the reference).
struct ProfileEnergy {
  double gradient = 0.0;        ///< E_RG: mean squared gradient
  double height_error_m2 = 0.0; ///< E_h: mean squared difference to the terrain
};

struct EstimateProfilesResult {
  RoadNetwork roads;  ///< z_m, gradient, sigma_z_m of every node; banking 0 with banking_source "none"
  SolveSummary solve;
  ProfileEnergy before, after;  ///< of the sampled terrain and of the result
  Findings findings;  ///< "elevate.no_terrain", "elevate.low_clearance", "elevate.not_converged"
};

/// Terrain models share the roads' CRS (throws OptionError), best first: a node takes the first one that has a height there.
/// Throws OptionError when there is none at all on the whole network.
[[nodiscard]] EstimateProfilesResult estimate_profiles(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms,
                                                       const ElevateOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
