#pragma once
// The reference's ways of giving a road heights, each way for itself: moving averages of the terrain, and the nonlinear
// optimisation of "From Aerial Images to Virtual Driving Environments" (2016), sec. 3.4.2.

#include <vector>

#include "orthodrive/elevate/robust_fit.hpp"
#include "orthodrive/model/road_network.hpp"

namespace orthodrive::elevate {

/// [path][node], m
using NodeHeights = std::vector<std::vector<double>>;

/// Mean over `window` (odd) samples around each node; towards the ends of a way the window shrinks to what lies on both
/// sides, so that an end stays where it is; around a closed way it goes on. What the thesis does there it does not say.
[[nodiscard]] NodeHeights moving_average(const RoadNetwork& roads, const NodeHeights& terrain_m, int window);

/// Residuals of eq. 3.15 to 3.17 with the weights of table 3.5, a Cauchy loss of 0.5 on the last, the terrain as
/// initial condition. Ways share nothing, bridges are like any other road.
struct WayProfiles {
  NodeHeights z_m;
  RobustFit::Summary solve;
};
[[nodiscard]] WayProfiles reference_profiles(const RoadNetwork& roads, const NodeHeights& terrain_m,
                                             int max_iterations);

}  // namespace orthodrive::elevate
