// SPDX-License-Identifier: Apache-2.0
#pragma once
// Routes that together lead over every road.

#include <vector>

#include "orthodrive/drive/routes/route.hpp"

namespace orthodrive {

/// Open routes that drive every road of the largest connected part in every direction that has a driving lane, turning
/// roads of junctions too, and few roads twice: each goes on to the nearest road that is still to be driven (a greedy
/// walk, as for the rural postman), over others where need be, until it is 3 km long or nothing is left to reach. A
/// route begins and ends with at least 12 m outside junctions where there are as many. Connected: by links of the
/// lanes' directions, whichever way they are taken. Deterministic.
[[nodiscard]] std::vector<Route> routes_over_all_roads(const roadquery::RoadMap& map);

}  // namespace orthodrive
