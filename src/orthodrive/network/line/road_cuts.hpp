// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where along a stretch one road ends and the next begins.

#include <vector>

#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/network/line/chain_geometry.hpp"
#include "orthodrive/network/line/stretches.hpp"

namespace orthodrive::network {

/// s along the chain where the roads of every stretch begin and end, empty for stretches inside a junction. Roads
/// change where ways do, but not in a bend: a car, and every reader that works with polylines, wants to enter a
/// junction or the next road in a calm piece. So cuts are moved by up to 15 m (out of a junction) or 25 m (between
/// ways; 1 m where a bridge or tunnel begins) to where the line, sampled every 2 m, turns with a radius of 14 m or
/// more, and from there by up to 5 m to where an element of the line ends, so that none is cut in two. A road that
/// leads back into its own junction becomes three and a second road between the same two junctions two: then no two
/// roads join the same pair of places, as graphs of nodes and edges want it.
[[nodiscard]] std::vector<std::vector<double>> cut_roads(const RoadNetwork& roads, const Topology& topology,
                                                         const ChainGeometries& geometry, const JunctionPlan& junctions,
                                                         DrivingSide driving_side);

/// Readers that sample elements every 2 m from their start get a short rest at the end. In a bend that looks like a
/// corner where the road ends, and it turns round where the lanes' line lies `offset_m` beside, inside the bend.
/// Elements for which that is so are divided in two such that their last two samples lie equally far apart; nothing
/// else changes.
[[nodiscard]] std::vector<roadquery::PlanElement> divide_slivers(std::vector<roadquery::PlanElement> plan,
                                                                 double offset_m);

}  // namespace orthodrive::network
