// SPDX-License-Identifier: Apache-2.0
#pragma once
// Side roads turn into the surface of the road that they meet before they reach it.

#include <vector>

#include "orthodrive/network/line/stretches.hpp"

namespace orthodrive::network {

/// The profile of a side road leads to the axis of the main road, and knows nothing of its cross slope: behind the edge
/// of the carriageway the side road lies too high or too low, and its banking is its own. Where a chain ends at a
/// vertex that another one (or itself) runs through, or crosses one of higher class (then wider), height, gradient and
/// banking at its cuts become those of the main road's surface, carried on beyond its edge, and its crown ends; what is
/// left is a break of 2 % of gradient and 1 % of banking, for drainage and visibility, over the corner. Where no chain
/// runs through, the main road is the one of the highest class (then the widest) that ends there. The change fades out
/// over 20 m, over up to 50 m where it is large: banking then changes by at most 0.5 %/m, as RAS-L (FGSV 1995, 7.3:
/// largest relative gradient of an edge 0.5 % times its distance from the axis in m) allows at 40 - 50 km/h; by twice
/// that on roads too short for it. `cuts`: of cut_roads().
void ease_arms(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
               const std::vector<std::vector<double>>& cuts, ChainGeometries& geometry);

}  // namespace orthodrive::network
