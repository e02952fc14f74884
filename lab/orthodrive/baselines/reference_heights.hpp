// SPDX-License-Identifier: Apache-2.0
#pragma once
// The reference's methods for the heights of roads, one OSM way at a time: moving averages of the terrain (table 3.6)
// and the nonlinear optimisation of "From Aerial Images to Virtual Driving Environments" (2016), sec. 3.4.2.

#include <vector>

#include "orthodrive/model/roads/node_heights.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Moving average of sec. 3.4.3: the mean over `window` (odd) samples around each node. Near the ends of a way the
/// window shrinks symmetrically, so that an end keeps its height; around a closed way it wraps. The thesis does not
/// state what happens at ends. Throws OptionError for an even window.
[[nodiscard]] NodeHeights moving_average(const RoadNetwork& roads, const NodeHeights& terrain_m, int window);

/// Residuals of eq. 3.15 to 3.17 with the weights of table 3.5, a Cauchy loss on the last, the terrain as initial
/// condition. Ways share nothing, bridges are like any other road. Throws OptionError for a loss of no scale.
struct ReferenceHeightsOptions {
  /// Scale of the Cauchy loss, a height difference. The thesis has "a normalization value of 0.5" and does not say of
  /// what. Of the difference in metres it gives the E_h of table 3.6; of the weighted residual (2.5 m here) it leaves
  /// 20 times the published E_h to the corrected terrain (docs/notes/elevate.md).
  double loss_m = 0.5;
  int max_iterations = 50;
};
[[nodiscard]] SolvedHeights reference_heights(const RoadNetwork& roads, const NodeHeights& terrain_m,
                                              const ReferenceHeightsOptions& options = {});

}  // namespace orthodrive
