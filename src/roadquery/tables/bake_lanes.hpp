// SPDX-License-Identifier: Apache-2.0
#pragma once
// The parts of a baked road that its stations share: lanes and lateral profile.

#include "roadquery/tables/baked_road.hpp"

namespace roadquery {

/// Appends the stretches of a road, ordered by s; the first one also holds before it. Throws std::runtime_error when
/// the map has more lane records than memory should be spent on.
void bake_lanes(const Road& road, BakedRoads& baked);

/// Pieces of the lateral profile of a road from s on; none where the road is flat.
struct ShapeRow {
  double s = 0.0;
  std::uint32_t first = 0;
  std::uint16_t count = 0;
};
/// Appends the pieces of a road and gives its rows, ordered by s.
[[nodiscard]] std::vector<ShapeRow> bake_shapes(const Road& road, BakedRoads& baked);

}  // namespace roadquery
