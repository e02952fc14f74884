// SPDX-License-Identifier: Apache-2.0
#pragma once
// Carriageways that lie on each other outside junctions.

#include "orthodrive/network/line/stretches.hpp"

namespace orthodrive::network {

/// Dead ends whose last cross section touches a surface of another height that they are not linked to end before it: up
/// to 10 m sooner, but not by more than half of their road. Between both a bank as wide as high stays free.
void end_before_roads(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                      const ChainGeometries& geometry, std::vector<std::vector<double>>& cuts);

/// Widths are measured road by road. Where two roads run side by side nearer to each other than half their widths
/// together, both would be the surface of the strip between them, each with a height of its own: the road of the lower
/// class (then the narrower one) gives way to the other up to its edge, but keeps what a car needs there
/// (least_carriageway_m); what is missing the other gives, if it is no more than 1.5 m. Where their surfaces are over
/// 1 cm apart at the edges a bank as wide as high, at most half a metre, stays free. Roads more than 1.5 m apart in
/// height or 30 degrees in heading are left alone, and so is what lies on a road by more than 5 m, or by more than 1.5
/// m where both part at one node. Roads give way to what lies in a junction that is not theirs. Widths change by 0.05 m
/// per metre at most. Heights must be final but for those inside junctions.
void leave_room_beside(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                       const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry);

}  // namespace orthodrive::network
