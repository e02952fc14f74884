// SPDX-License-Identifier: Apache-2.0
#pragma once
// The roads themselves: pieces of chains between the cuts, and the roads that connect them through junctions.

#include <map>
#include <vector>

#include "orthodrive/network/build_network.hpp"
#include "orthodrive/network/chain_geometry.hpp"
#include "orthodrive/network/stretches.hpp"
#include "orthodrive/network/topology.hpp"

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

/// Roads of all stretches, linked where they follow each other without a junction, ids from 1. Returns the ends at
/// every junction, in the order of the stretches. Finding network.too_many_lanes: more were tagged than the width has
/// room for.
[[nodiscard]] std::vector<std::vector<JunctionEnd>> add_roads(const NetworkPlan& plan, roadquery::RoadMap& map,
                                                              Findings& findings);

struct JunctionParts {
  std::vector<int> straight;  ///< ids of the connecting roads that go straight on, cut from their chain, ascending
  std::map<int, double> kerb_radius_m;  ///< of the junctions of which it was seen: the median of their nodes'
};

/// Connecting roads and junctions. From every incoming lane group to every other road of the junction that can be
/// reached: no U-turns, one-way roads in their direction. Junctions without any connection are left out. Finding
/// network.turn_left_out: turns of 140 to 150 degrees into a road that leads back to the same other junction.
JunctionParts add_junctions(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends,
                            roadquery::RoadMap& map, Findings& findings);

}  // namespace orthodrive::network
