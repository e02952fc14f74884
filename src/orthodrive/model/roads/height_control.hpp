// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights of roads that somebody knows: height control points, as surveyors say.

#include <cstdint>
#include <limits>
#include <optional>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

struct HeightControlPoint {
  Vec2 p;                                                         ///< on the road, site CRS
  double z_m = std::numeric_limits<double>::quiet_NaN();          ///< of the road's surface; NaN: not told
  double clearance_m = std::numeric_limits<double>::quiet_NaN();  ///< of a deck over the road below it; NaN: not told
  double sigma_m = 0.05;                                          ///< of both: what satellite positioning reaches
  std::int64_t osm_id = 0;                                        ///< of the way; 0: not told
  std::optional<int> layer;                                       ///< of the way
};

}  // namespace orthodrive
