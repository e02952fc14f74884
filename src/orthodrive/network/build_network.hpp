// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "network": roads with widths and heights -> OpenDRIVE roads, lanes and junctions. docs/network.md tells the
// method.

#include <cstddef>
#include <string>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/model/driving_side.hpp"
#include "orthodrive/model/road_material.hpp"
#include "orthodrive/model/road_network.hpp"
#include "orthodrive/network/junction_surface.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive {

struct BuildNetworkOptions {
  std::string name = "orthodrive";  ///< header/@name
  /// Largest distance of a node from the reference line. Refined lines are uncertain by some decimetres; following them
  /// more closely turns their noise into curvature.
  double plan_tolerance_m = 0.10;
  double elevation_tolerance_m = 0.02;   ///< largest height error at a node
  double banking_tolerance_rad = 0.002;  ///< largest superelevation error at a node
  double width_tolerance_m = 0.05;       ///< largest error of the carriageway width at a node
  /// Heights change by no more for the sake of fewer entries of crown and superelevation.
  double shape_tolerance_m = 0.0048;
  DrivingSide driving_side = DrivingSide::right;
  Weather weather = Weather::dry;    ///< what the friction of the lanes is for
  bool junction_surfaces = true;     ///< one surface for the paved area of each junction
  int threads = 0;                   ///< 0 = all cores; the result does not depend on it
  LoopExchange* exchange = nullptr;  ///< with other processes that build the same network; nor on it
};

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
