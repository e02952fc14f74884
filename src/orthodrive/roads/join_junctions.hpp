// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lets chains that share an OSM node meet in one point.

#include <vector>

#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive {

/// Where chains meet, and how sure each of them may be that its line passes there.
struct JunctionPlace {
  struct Pass {
    std::size_t chain = 0, node = 0;
    double sigma_m = 0.0;
  };
  Vec2 p;
  std::vector<Pass> passes;
};
/// For each shared OSM node the point that lies on all lines that meet there, higher ranked and passing roads counting
/// more; near junctions move alike (linear least squares over the network). `lines[c][i]` is node i of chain c.
[[nodiscard]] std::vector<JunctionPlace> place_junctions(const std::vector<RoadChain>& chains,
                                                         const std::vector<Polyline>& lines);

/// `lines[c][i]` is the fitted position of node i of chain c; it is moved: every chain passes through the places of its
/// junctions and bends to them smoothly, over `bend_m`.
void bend_to_junctions(const std::vector<RoadChain>& chains, const std::vector<JunctionPlace>& places,
                       std::vector<Polyline>& lines, double bend_m = 25.0);

}  // namespace orthodrive
