// SPDX-License-Identifier: Apache-2.0
#pragma once
// Road marks of OpenDRIVE as polygons in plan.

#include <array>
#include <string_view>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/rasters/srgb.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::scene {

inline constexpr LinearColor white_paint = {0.62F, 0.62F, 0.60F};

/// A piece of a line: counter-clockwise, convex but in bends tighter than the line is wide.
struct MarkingPiece {
  std::array<Vec2, 4> corners;
  LinearColor color = white_paint;
};

/// Length of the strokes and of the gaps of a broken line by the speed limit: 3 and 6 m up to 60 km/h, 4 and 8 m up to
/// 100 km/h, 6 and 12 m above and where none is given on motorways and trunk roads. Source: Richtlinien fuer die
/// Markierung von Strassen (RMS-1, 1993), Leitlinie.
struct DashPattern {
  double stroke_m = 3.0, gap_m = 6.0;
};
[[nodiscard]] DashPattern dash_pattern(const roadquery::Road& road);

/// Of OpenDRIVE's names (1.8.1, e_roadMarkColor); white for others.
[[nodiscard]] LinearColor paint_color(std::string_view name);

/// All marks of a road. A mark lies in the middle of the border of its lane, that of an outermost lane inside the lane.
/// Its lines are those that are written out for it, or those that its type means: two lines ("solid broken": from the
/// inside outwards, of the centre lane from the left to the right) lie as far apart as they are wide. Curbs, grass,
/// edges and custom marks without lines are no paint. Pieces are at most 5 m long and leave the line by at most 1 cm.
[[nodiscard]] std::vector<MarkingPiece> road_markings(const roadquery::Road& road);

}  // namespace orthodrive::scene
