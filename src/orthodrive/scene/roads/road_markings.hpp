// SPDX-License-Identifier: Apache-2.0
#pragma once
// Road marks of OpenDRIVE as polygons in plan.

#include <array>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive::scene {

/// A piece of a line: counter-clockwise, convex but in bends tighter than the line is wide.
using MarkingPiece = std::array<Vec2, 4>;

/// Length of the strokes and of the gaps of a broken line by the speed limit: 3 and 6 m up to 60 km/h, 4 and 8 m up to
/// 100 km/h, 6 and 12 m above and where none is given on motorways and trunk roads. Source: Richtlinien fuer die
/// Markierung von Strassen (RMS-1, 1993), Leitlinie.
struct DashPattern {
  double stroke_m = 3.0, gap_m = 6.0;
};
[[nodiscard]] DashPattern dash_pattern(const roadquery::Road& road);

/// All solid and broken marks of a road. A mark lies in the middle of the border of its lane, that of an outermost lane
/// inside the lane. Curbs are no paint. Pieces are at most 5 m long and leave the line by at most 1 cm.
[[nodiscard]] std::vector<MarkingPiece> road_markings(const roadquery::Road& road);

}  // namespace orthodrive::scene
