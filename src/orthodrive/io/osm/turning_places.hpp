// SPDX-License-Identifier: Apache-2.0
#pragma once
// Room that tags on nodes tell of: turning circles and loops, passing places.

#include <cstdint>
#include <optional>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/io/osm/osm_tags.hpp"

namespace orthodrive::io {

struct TurningPlace {
  std::int64_t osm_node = 0;
  bool is_circle = true;     ///< else a passing place
  double diameter_m = 12.0;  ///< of the circle
};

/// highway=turning_circle, turning_loop and passing_place, with diameter or width.
[[nodiscard]] std::optional<TurningPlace> turning_place(std::int64_t osm_node, const OsmTags& tags);

/// Widens the roads at those nodes. A road that ends at a circle's middle goes on to its far side, within the area.
void widen_at(const std::vector<TurningPlace>& places, const Polygon& area, RoadNetwork& roads);

}  // namespace orthodrive::io
