// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a junction's own surface is the answer, whatever else lies there.

#include "roadquery/tables/cell_index.hpp"

namespace roadquery {

/// Clears BakedRoads::deciding_junction where surfaces may be of more than one level. The companions are known.
void find_levels(BakedRoads& roads, const RoadMap& map, const CellIndex& cells);

}  // namespace roadquery
