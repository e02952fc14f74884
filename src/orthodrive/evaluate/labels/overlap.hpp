// SPDX-License-Identifier: Apache-2.0
#pragma once
// Areas of overlapping polygon sets, exact to a grid of a millimetre.

#include <vector>

#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::evaluate {

struct OverlapAreas {
  double first_m2 = 0.0, second_m2 = 0.0, both_m2 = 0.0;
  [[nodiscard]] double iou() const { return both_m2 / (first_m2 + second_m2 - both_m2); }  ///< NaN when both are empty
};
/// Areas of the unions of both sets, each counted once where its polygons overlap, inside the region.
[[nodiscard]] OverlapAreas overlap_areas(const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                                         const ScoreRegion& region);

/// What of the unions of both sets, inside the region, is in one of them alone, as valid polygons with holes.
struct OverlapDifferences {
  MultiPolygon first, second;
};
[[nodiscard]] OverlapDifferences overlap_differences(const std::vector<Polygon>& first,
                                                     const std::vector<Polygon>& second, const ScoreRegion& region);

/// Polygons whose union is the carriageway of the path: the strip itself, or its cells where a tight bend folds it.
[[nodiscard]] std::vector<Polygon> carriageway_polygons(const RoadPath& path);

}  // namespace orthodrive::evaluate
