// SPDX-License-Identifier: Apache-2.0
#pragma once
// Humps that the map knows, as heights of the roads.

#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/network/line/chain_geometry.hpp"
#include "orthodrive/network/line/stretches.hpp"

namespace orthodrive::network {

/// A hump as it was built.
struct RaisedHump {
  std::string value;  ///< of OSM's traffic_calming
  Vec2 p, direction;  ///< its middle, and along the road
  double length_m = 0.0, height_m = 0.0;
};

/// Adds the humps of nodes and ways (hump_profile) to the profiles of the chains, from kerb to kerb and level with them
/// at both ends: C1. They lie between the cuts of their road, a metre off those at junctions, and are moved there where
/// their node lies nearer. Of a way that is a table all is raised; other humps of a way lie in its middle if it is not
/// much longer than they are.
/// Findings: network.hump_left_out (no room; a raised junction; one of several somewhere on a way).
[[nodiscard]] std::vector<RaisedHump> raise_humps(const RoadNetwork& roads, const Topology& topology,
                                                  const JunctionPlan& junctions,
                                                  const std::vector<std::vector<double>>& cuts,
                                                  ChainGeometries& geometry, Findings& findings);

/// Adds a hump to a profile of cubics in s: from `begin` up `ramp_m` to `height_m`, `plateau_m` on, and down again.
void add_hump(std::vector<roadquery::Cubic>& profile, double begin, double ramp_m, double plateau_m, double height_m);

}  // namespace orthodrive::network
