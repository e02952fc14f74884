// SPDX-License-Identifier: Apache-2.0
#pragma once
// What fine terrain models show of the carriageway: their own pixels, each seen from the nearest station.

#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/elevate/terrain/chain_stations.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive::elevate {

/// A pixel of the terrain that lies on the carriageway. Pixels are taken as they are: between them nothing is measured,
/// and their errors are independent.
struct AcrossSample {
  std::uint32_t station = 0;
  float t_m = 0.0f;     ///< of the pixel's centre, positive to the left of the chain
  float rise_m = 0.0f;  ///< over the road's profile
  float gsd_m = 0.0f;
};

/// Samples of every chain, by station. Left out: pixels with more than a quarter over the edge (the shoulder falls
/// away), on and beside bridges and tunnels, and where another road's surface is (junctions, and within 1 m of an edge
/// of another one). The first of the models with a pixel at a station counts there; models coarser than
/// `coarsest_gsd_m` do not count.
[[nodiscard]] std::vector<std::vector<AcrossSample>> gather_across_samples(const NetworkStations& network,
                                                                           std::span<const HeightGrid> dtms,
                                                                           double coarsest_gsd_m);

}  // namespace orthodrive::elevate
