// SPDX-License-Identifier: Apache-2.0
#pragma once
// Polygon overlay and noding by GEOS (OverlayNG with snap rounding, which does not fail), values in and out.
// Coordinates of results are multiples of the grid size. Give small coordinates: those of UTM cost digits.

#include <span>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {

struct LineSegment {
  Vec2 a, b;
};

/// Results: outer rings counter-clockwise, holes clockwise, in an order that depends on the input only. Polygons of the
/// input may be invalid (fold over themselves): they are made valid first.
/// The union also takes polygons that overlap each other.
[[nodiscard]] MultiPolygon union_of(std::span<const Polygon> polygons, double grid_m);
/// Both sets must be free of overlaps, as results of these functions are.
[[nodiscard]] MultiPolygon intersection_of(const MultiPolygon& a, const MultiPolygon& b, double grid_m);
[[nodiscard]] MultiPolygon difference_of(const MultiPolygon& a, const MultiPolygon& b, double grid_m);

/// All points within the distance of the polygons (negative: all whose surroundings lie inside). Round corners are
/// polygons of `arc_steps` sides a quarter turn, inside the arc by up to distance * (1 - cos(45 degrees / arc_steps)).
/// The polygons may overlap, but many that do take the square of their number: unite them first.
[[nodiscard]] MultiPolygon buffer_of(const MultiPolygon& polygons, double distance_m, int arc_steps = 16);
/// All points within the distance beside lines: they end flat, and corners of more than about 90 degrees are cut. Lines
/// of a single place have none.
[[nodiscard]] MultiPolygon buffer_of_lines(std::span<const Polyline> lines, double distance_m);
/// Fewer points: the border moves by up to the tolerance, rings stay simple and apart (Douglas and Peucker 1973).
[[nodiscard]] MultiPolygon simplified(const MultiPolygon& polygons, double tolerance_m);

/// Splits lines where they meet or cross, drops duplicates and snaps to the grid: the segments returned touch each
/// other at their ends only. Axis-parallel lines on the grid stay where they are.
[[nodiscard]] std::vector<LineSegment> node_lines(std::span<const Polyline> lines, double grid_m);

/// Whether a ring is a valid polygon: it neither crosses nor touches itself.
[[nodiscard]] bool is_simple(const Ring& ring);

}  // namespace orthodrive
