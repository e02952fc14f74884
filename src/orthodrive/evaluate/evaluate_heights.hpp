#pragma once
// How well heights, gradients and banking of roads agree with a terrain model or with true roads.

#include "orthodrive/evaluate/scores.hpp"
#include "orthodrive/model/rasters.hpp"
#include "orthodrive/model/road_network.hpp"

namespace orthodrive {

struct HeightScores {
  ErrorSummary z_m;
  ErrorSummary gradient;                ///< dz/ds
  ErrorSummary banking;                 ///< rad
  double gradient_energy = 0.0;         ///< mean squared gradient of the roads (thesis eq. 3.13)
  double height_error_energy_m2 = 0.0;  ///< mean squared difference of the heights (thesis eq. 3.12)
  std::size_t nodes = 0;                ///< in the region and with a height
  double compared_share = 0.0;          ///< of them that the truth has a height for
};

/// Compares at the nodes. Truth of the gradient: the terrain's slope along the road over two pixels; of the banking:
/// the slope between both edges of the carriageway. Bridges and tunnels are left out: a terrain model has no decks.
[[nodiscard]] HeightScores evaluate_heights(const RoadNetwork& roads, const HeightGrid& terrain,
                                            const ScoreRegion& region = {});

/// Compares each node with the surface of the true road across from it (within 10 m, 30 degrees, of the same layer).
[[nodiscard]] HeightScores evaluate_heights(const RoadNetwork& roads, const RoadNetwork& truth,
                                            const ScoreRegion& region = {});

}  // namespace orthodrive
