// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which paths traffic drives round on: maps often lack the tag of a roundabout, its form stays.

#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// For each path the ring that it is part of, -1 for none: it is tagged as a roundabout, or one-way paths lead from end
/// to end round a circle of 25 to 220 m. Of blocks of houses the roundness (geo/roundness) is too small. Rings are
/// numbered in the order of their first path; tagged ways that share an end are one ring.
[[nodiscard]] std::vector<int> rings_of_paths(const RoadNetwork& roads);

/// Width of the carriageway of a ring whose centre line is so long, without the strip at its island that trucks alone
/// drive over: three quarters of the ring's width by its outer diameter. FGSV, Merkblatt fuer die Anlage von
/// Kreisverkehren, 2006, table 3.
[[nodiscard]] double usual_ring_width_m(double centre_line_m);

}  // namespace orthodrive
