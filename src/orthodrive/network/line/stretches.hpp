// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far roads are cut back at junctions, and which junctions are so close that they are one.

#include <vector>

#include "orthodrive/network/line/chain_geometry.hpp"
#include "orthodrive/network/topology/topology.hpp"

namespace orthodrive::network {

/// The part of a chain between two junctions (or ends). Closed chains: the last one may end at length_m, never beyond.
struct Stretch {
  ChainIndex chain;
  double s0 = 0.0, s1 = 0.0;
  VertexIndex vertex0, vertex1;         ///< junction at s0 and s1, or none
  double trim0_m = 0.0, trim1_m = 0.0;  ///< cut back there
  bool inside = false;                  ///< between two vertices of one junction, or a dead end: no road of its own
};

/// One end of a stretch at a junction.
struct Arm {
  std::size_t stretch = 0;
  bool at_s1 = false;
};

struct JunctionPlan {
  std::vector<Stretch> stretches;              ///< chain by chain, along the chain
  Table<VertexIndex, int> junction_of_vertex;  ///< -1 for vertices that are none
  int junctions = 0;
};

/// A road ends where its whole cross section has left the carriageways of the other roads of the junction and of the
/// ways inside it, plus 4 m for the corner, more where two cars meet in less than 5.5 m; the carriageways of one road,
/// within 15 degrees of each other, have parted when 60 % of their widths has, and end side by side where less than 1.5
/// m is between them. Two junctions between which less than a car and its gap (7.5 m) would be left are one, as long as
/// its vertices lie within 40 m; else both cuts are shortened. A dead end of which nothing would be left has no road.
[[nodiscard]] JunctionPlan plan_junctions(const RoadNetwork& roads, const Topology& topology,
                                          const ChainGeometries& geometry);

}  // namespace orthodrive::network
