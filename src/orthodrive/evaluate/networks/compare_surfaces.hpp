// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far the surfaces of two versions of a network lie apart, e.g. of one built and of its file read back.

#include "roadquery/map/road_map.hpp"

namespace orthodrive {

struct SurfaceComparison {
  double max_distance_m = 0.0;  ///< between points of the same road, s and t; NaN without a common road
  int road = 0;                 ///< where
  double s = 0.0;
  std::size_t points = 0;
  std::size_t missing_roads = 0;  ///< ids that only one of them has, or whose lengths differ by more than 1 mm
};

/// Compares both edges and the middle of the carriageway of every road, at its ends and every 2 m between.
[[nodiscard]] SurfaceComparison compare_surfaces(const roadquery::RoadMap& a, const roadquery::RoadMap& b);

}  // namespace orthodrive
