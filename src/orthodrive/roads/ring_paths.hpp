#pragma once
// Which paths traffic drives round on: maps often lack the tag of a roundabout, its form stays.

#include <vector>

#include "orthodrive/model/road_network.hpp"

namespace orthodrive {

/// For each path whether it is part of a ring: it is tagged as a roundabout, or one-way paths lead from end to end
/// round a circle of 25 to 220 m. Of blocks of houses the roundness (geo/roundness) is too small.
[[nodiscard]] std::vector<bool> paths_on_rings(const RoadNetwork& roads);

}  // namespace orthodrive
