// SPDX-License-Identifier: Apache-2.0
#pragma once
// Pictures of right and wrong road surface, as the figures of chapter 3 of the thesis show them.

#include <vector>

#include "orthodrive/evaluate/roads/evaluate_roads.hpp"
#include "orthodrive/report/canvas.hpp"

namespace orthodrive {

/// Carriageways, polygons that may overlap each other, in one CRS.
struct RoadSurfaces {
  std::vector<Polygon> ours, truth;
};

/// A grid around both and a margin, of 0.25 m a pixel or coarser so that no edge is longer than max_px; the region's
/// area limits it. Throws Error when there is nothing to show.
[[nodiscard]] GridFrame road_picture_frame(const RoadSurfaces& surfaces, const ScoreRegion& region, int max_px = 4000);

/// The photo (null: even grey) in grey; over it road surface that is right pale yellow, ours alone (false positive)
/// red, the truth's alone (false negative) blue, by pixel centres. Outside the region everything is pale.
[[nodiscard]] Canvas picture_of_road_errors(const RoadSurfaces& surfaces, const ScoreRegion& region,
                                            const GridFrame& frame, const Photo* photo);

}  // namespace orthodrive
