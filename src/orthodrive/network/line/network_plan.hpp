// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the roads of a network are made of, once their lines are decided.

#include <vector>

#include "orthodrive/network/line/chain_geometry.hpp"
#include "orthodrive/network/line/network_options.hpp"
#include "orthodrive/network/line/stretches.hpp"
#include "orthodrive/network/topology/topology.hpp"

namespace orthodrive::network {

/// What the parts of the stage share: never changed once built.
struct NetworkPlan {
  const RoadNetwork& given;  ///< the same paths before crossings were joined, rings closed and carriageways widened
  const RoadNetwork& roads;
  const Topology& topology;
  const ChainGeometries& geometry;
  const JunctionPlan& junctions;
  const std::vector<std::vector<double>>& cuts;  ///< of cut_roads(), by stretch
  const BuildNetworkOptions& options;
};

/// A road that ends at a junction.
struct JunctionEnd {
  int road = 0;         ///< index in RoadMap::roads
  bool at_end = false;  ///< of the road: its end (else its start) touches the junction
  VertexIndex vertex;
  std::size_t stretch = 0;
  bool at_begin = false;  ///< of the stretch: where its chain leaves the junction
  double chain_s = 0.0;   ///< where on the stretch's chain
  std::size_t path = 0;   ///< of the road, which runs along it
  int through = -1;       ///< index of the end that its chain goes on to, in the same junction's list
};

}  // namespace orthodrive::network
