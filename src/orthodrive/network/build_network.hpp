// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "network": roads with widths and heights -> OpenDRIVE roads, lanes and junctions. docs/network.md tells the
// method.

#include <cstddef>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/junctions/fit_junction_surfaces.hpp"
#include "orthodrive/network/line/network_options.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

struct NetworkResult {
  roadquery::RoadMap map;
  /// Over all nodes, against the input after joints were closed and bends eased (fit_plan.hpp, chain_line.hpp).
  double max_plan_deviation_m = 0.0, max_elevation_error_m = 0.0;
  double chain_length_m = 0.0;     ///< of the fitted chains, before they are cut into roads
  std::size_t chain_elements = 0;  ///< lines, arcs, clothoids and cubics of the chains
  int eased_nodes = 0;             ///< nodes moved because a bend was sharper than the carriageway is wide
  network::JunctionSurfaceSummary junction_surfaces;
  Findings findings;
};

/// One road per piece of path between shared nodes. Where two pieces meet end to end they are linked directly; where
/// three or more meet the roads are cut back and a junction joins their lanes. Paths without heights lie flat at z = 0.
/// An empty network gives an empty map.
[[nodiscard]] NetworkResult build_network(const RoadNetwork& roads, const BuildNetworkOptions& options = {},
                                          Monitor* monitor = nullptr);

}  // namespace orthodrive
