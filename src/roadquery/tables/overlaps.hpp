// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which surfaces of baked roads lie one over or beside the other.

#include "roadquery/tables/cell_index.hpp"

namespace roadquery {

/// The rectangle in a station's frame that holds its surface.
struct StationBox {
  double along_min = 0.0, along_max = 0.0, left_min = 0.0, left_max = 0.0;
};
[[nodiscard]] StationBox station_box(const BakedRoads& roads, const Station& station);

/// How far the cross section at u reaches behind its place on the line (< 0) and ahead of it: 0 unless it is turned.
struct AheadRange {
  double min_m = 0.0, max_m = 0.0;
};
[[nodiscard]] AheadRange ahead_range(const BakedRoads& roads, const Station& station, double u);

/// Fills in the companions of all stations, and the part of each one's width that neither they nor a junction's own
/// surface touch; deciding_junction where junctions touch a station, whatever their level. Surfaces of roads further
/// apart than `level_m` in height are none of each other's business.
void find_overlaps(BakedRoads& roads, const RoadMap& map, const CellIndex& cells, double level_m);

}  // namespace roadquery
