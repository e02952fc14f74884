#pragma once
// Roofs over footprints.

#include <array>
#include <string_view>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::scene {

enum class RoofShape { flat, gabled, hipped };

/// Heights are over the eaves. Triangles are counter-clockwise seen from outside.
struct Roof {
  RoofShape shape = RoofShape::flat;  ///< what was possible
  double rise_m = 0.0;                ///< from the eaves to the ridge
  std::vector<std::array<Vec3, 3>> slopes;
  std::vector<std::array<Vec3, 3>> gables;  ///< upright, over walls
};

/// A roof of the shape asked for over a footprint as overlays give them (outer counter-clockwise, holes clockwise, on
/// the plan grid), with slopes of
/// `pitch` (tangent) that rise by at most max_rise_m. Gabled: over rectangles (four corners within 12 degrees of a
/// right angle) only, the ridge along the longer side; others become hipped. Hipped: every edge of the footprint is an
/// eave, by the straight skeleton (Aichholzer et al., A novel type of skeleton for polygons, 1995; CGAL). Footprints of
/// more than 40 corners, that touch themselves, or whose skeleton fails or crosses itself, are flat.
[[nodiscard]] Roof make_roof(const Polygon& footprint, RoofShape wanted, double pitch, double max_rise_m);

}  // namespace orthodrive::scene
