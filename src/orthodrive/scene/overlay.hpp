#pragma once
// Polygon overlay and noding by GEOS (OverlayNG with snap rounding), values in and out.

#include <cmath>
#include <span>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive::scene {

/// All plan coordinates of the scene are multiples of this. A power of two: offsets of up to 16 km from a point of the
/// grid are exact in float, so that triangles cannot flip and tile borders cannot open when doubles become floats.
constexpr double plan_grid_m = 1.0 / 1024.0;

[[nodiscard]] inline Vec2 snap_to_grid(Vec2 p) {
  return {std::round(p.x / plan_grid_m) * plan_grid_m, std::round(p.y / plan_grid_m) * plan_grid_m};
}

struct Segment {
  Vec2 a, b;
};

/// Outer rings counter-clockwise, holes clockwise, on the plan grid; in an order that depends on the input only.
[[nodiscard]] MultiPolygon union_of(std::span<const Polygon> polygons);
[[nodiscard]] MultiPolygon intersection_of(const MultiPolygon& a, const MultiPolygon& b);
/// Splits lines where they meet or cross, drops duplicates and snaps to the plan grid: the segments returned touch each
/// other at their ends only. Axis-parallel lines on the grid stay where they are.
[[nodiscard]] std::vector<Segment> node_lines(std::span<const Polyline> lines);

}  // namespace orthodrive::scene
