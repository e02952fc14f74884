// SPDX-License-Identifier: Apache-2.0
#pragma once
// The pieces of a line inside a polygon, with the vertices that survive known by their index.

#include <cstddef>
#include <optional>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive::io {

struct ClippedPoint {
  Vec2 p;
  std::optional<std::size_t> vertex;  ///< of the line; none where the border cuts it
};

/// Pieces in the order of the line, each at least two points. O(points * border edges near them).
[[nodiscard]] std::vector<std::vector<ClippedPoint>> clip_line(const Polyline& line, const Polygon& area);

}  // namespace orthodrive::io
