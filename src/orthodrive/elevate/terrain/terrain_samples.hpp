// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the terrain models say at the nodes of the roads, and where that is the road.

#include <cstdint>
#include <limits>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::elevate {

struct TerrainSample {
  double z_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN: no model has a height here
  float spread_m = 0.0F;    ///< standard deviation that the lie of the land adds: slope and bend across the road
  std::uint8_t source = 0;  ///< index of the model
  bool is_road = false;     ///< has a height, and no bridge or tunnel is near
};

struct TerrainSamples {
  std::vector<std::vector<TerrainSample>> of_node;  ///< [path][node]
  std::vector<double> gsd_m;                        ///< of the models
  double coarsest_gsd_m = 0.0;                      ///< of those in use
};

/// The first model with a height counts. Throws OptionError when no node at all has one.
[[nodiscard]] TerrainSamples sample_terrain(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms,
                                            HeightSampling sampling, int threads);

/// A place along a path that a bridge or tunnel covers by this much to both sides.
struct Span {
  std::size_t path = 0;
  double s_m = 0.0, half_length_m = 0.0;
};
/// Marks where the terrain is not the road: bridges and tunnels, `spans`, and the way to the next pixel beyond (at
/// least 5 m): bare-earth models smear abutments and portals over about a pixel.
void leave_out_structures(const RoadNetwork& roads, const std::vector<Span>& spans, TerrainSamples& terrain);

/// Heights to start from, of every node: the terrain; linear along the path where it is not the road; the nearest
/// height of the network where the path has none.
[[nodiscard]] std::vector<std::vector<double>> start_heights(const RoadNetwork& roads, const TerrainSamples& terrain);

/// "elevate.no_terrain" for each way with holes, "elevate.implausible_terrain" when heights are none of the earth's or
/// the roads are as steep as feet taken for metres make them.
void report_terrain(const RoadNetwork& roads, const TerrainSamples& terrain, Findings& findings);

}  // namespace orthodrive::elevate
