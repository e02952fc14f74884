#pragma once
// Side roads turn into the surface of the road that they meet before they reach it.

#include <vector>

#include "orthodrive/network/stretches.hpp"

namespace orthodrive::network {

/// The profile of a side road ends at the axis of the main road, and knows nothing of its cross slope: behind the edge
/// of the carriageway the side road lies too high or too low, and its banking is its own. Where a chain ends at a
/// vertex that another one runs through, height, gradient and banking at the cut become those of the main road's
/// surface, carried on beyond its edge; what is left is a break of 3 % of gradient and 2 % of banking, for drainage and
/// visibility, over the corner. The change fades out over 20 m: banking then changes by at most 0.5 %/m, as RAS-L (FGSV
/// 1995, 5.5.3: largest relative gradient of 0.5 % times the distance of the edge from the axis) allows at 50 km/h.
/// `cuts`: of cut_roads().
void ease_arms(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
               const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry);

}  // namespace orthodrive::network
