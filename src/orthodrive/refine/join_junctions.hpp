#pragma once
// Lets chains that share an OSM node meet in one point.

#include <vector>

#include "orthodrive/refine/road_chains.hpp"

namespace orthodrive {

struct JoinOptions {
  double bend_m = 25.0;  ///< a chain bends to its junction over this distance
};

/// `lines[c][i]` is the fitted position of node i of chain c; it is moved. At each junction the point is sought that lies on
/// all lines that meet there, higher ranked and passing roads counting more; near junctions move alike. Then every
/// chain bends smoothly to its junctions.
void join_junctions(const std::vector<RoadChain>& chains, std::vector<Polyline>& lines, const JoinOptions& options = {});

}  // namespace orthodrive
