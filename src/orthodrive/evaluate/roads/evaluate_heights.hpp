// SPDX-License-Identifier: Apache-2.0
#pragma once
// How well heights, gradients and banking of roads agree with a terrain model or with true roads.

#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/evaluate/roads/profile_shape.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct HeightScores {
  ErrorSummary z_m;
  ErrorSummary gradient;                ///< dz/ds
  ErrorSummary banking;                 ///< rad
  double gradient_energy = 0.0;         ///< E_RG: mean squared gradient of the roads' segments (thesis eq. 3.13)
  double true_gradient_energy = 0.0;    ///< mean squared gradient of the truth at the nodes
  double gradient_error_energy = 0.0;   ///< mean squared difference of the gradients: E_RG against the true profile
  double height_error_energy_m2 = 0.0;  ///< E_h: mean squared difference of the heights (thesis eq. 3.12)
  SigmaCoverage sigma;                  ///< share of the heights within one and two stated sigma, NaN without any
  std::size_t nodes = 0;                ///< in the region and with a height
  double compared_share = 0.0;          ///< of them that the truth has a height for
  ProfileShape shape;                   ///< of the whole network in the region, bridges too
};

/// Compares at the nodes. Truth of the gradient: the terrain's slope along the road over two pixels; of the banking:
/// the slope between both edges of the carriageway. Bridges and tunnels are left out: a terrain model has no decks.
[[nodiscard]] HeightScores evaluate_heights(const RoadNetwork& roads, const HeightGrid& terrain,
                                            const ScoreRegion& region = {});

/// Compares each node with the surface of the true road across from it (within 10 m, 30 degrees, of the same layer).
[[nodiscard]] HeightScores evaluate_heights(const RoadNetwork& roads, const RoadNetwork& truth,
                                            const ScoreRegion& region = {});

}  // namespace orthodrive
