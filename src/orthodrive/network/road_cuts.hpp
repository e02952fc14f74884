#pragma once
// Where along a stretch one road ends and the next begins.

#include <vector>

#include "orthodrive/network/chain_geometry.hpp"
#include "orthodrive/network/stretches.hpp"

namespace orthodrive::network {

/// s along the chain where the roads of every stretch begin and end, empty for stretches inside a junction. Roads change
/// where ways do, but not in a bend: a car, and every reader that works with polylines, wants to enter a junction or the
/// next road in a calm piece. So cuts are moved by up to 10 m (out of a junction) or 15 m (between ways; 1 m where a bridge or
/// tunnel begins) to where the line, sampled every 2 m, turns with a radius of 9 m or more.
/// A road that leads back into its own junction becomes three and a second road between the same two junctions two: then no
/// two roads join the same pair of places, as graphs of nodes and edges want it.
[[nodiscard]] std::vector<std::vector<double>> cut_roads(const RoadNetwork& roads, const Topology& topology,
                                                         const std::vector<ChainGeometry>& geometry,
                                                         const JunctionPlan& junctions, bool left_hand_traffic);

}  // namespace orthodrive::network
