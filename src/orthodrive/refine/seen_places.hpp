// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a network that sees the map beside the photo (model/rasters/map_alignment.hpp) has the road of a chain's nodes.

#include <vector>

#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

struct SeenPlace {
  double offset_m = 0.0, sigma_m = 0.0;  ///< along the node's normal; sigma 0: nothing is said
  double width_m = 0.0, sigma_width_m = 0.0;
};

/// One a node, or none where nothing is said of the chain. A node takes the place of its path that is nearest along it.
[[nodiscard]] std::vector<SeenPlace> seen_on_chain(const RoadChain& chain, const RoadAlignment& alignment,
                                                   double sigma_factor = 1.0);

/// Both together, weighted by their variances.
[[nodiscard]] std::vector<ExpectedOffset> combine(const std::vector<ExpectedOffset>& expected,
                                                  const std::vector<SeenPlace>& seen);

}  // namespace orthodrive::refine
