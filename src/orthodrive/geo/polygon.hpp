// SPDX-License-Identifier: Apache-2.0
#pragma once
// Polygons as values and what is needed of them without an overlay library.

#include <functional>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

using Ring = std::vector<Vec2>;  ///< closed implicitly: the last point is not a repeat of the first

/// Outer ring counter-clockwise, holes clockwise by convention; the functions here work for any orientation (even-odd).
struct Polygon {
  Ring outer;
  std::vector<Ring> holes;
};
using MultiPolygon = std::vector<Polygon>;

/// Positive for counter-clockwise rings.
[[nodiscard]] double signed_area_m2(const Ring& ring);
[[nodiscard]] double area_m2(const Polygon& polygon);
[[nodiscard]] Polygon moved(Polygon polygon, Vec2 by);
[[nodiscard]] bool contains(const Polygon& polygon, Vec2 p);
[[nodiscard]] bool contains(const MultiPolygon& polygons, Vec2 p);
[[nodiscard]] Box2 bounds_of(const Ring& ring);
[[nodiscard]] Polygon polygon_of(const Box2& box);               ///< its corners, counter-clockwise
[[nodiscard]] Box2 bounds_of_all(const MultiPolygon& polygons);  ///< of one at least
/// Counter-clockwise, without points on its edges. Fewer than three points when all lie on one line.
[[nodiscard]] Ring convex_hull(std::vector<Vec2> points);

/// Calls span(row, first_col, end_col) for the pixels whose centre lies inside (even-odd), clipped to the grid,
/// rows ascending, spans left to right.
void rasterize(const Polygon& polygon, const GridFrame& frame, const std::function<void(int, int, int)>& span);

/// Sets all pixels with their centre inside to `value`.
template <typename T>
void fill_polygon(Raster<T>& raster, const GridFrame& frame, const Polygon& polygon, T value) {
  rasterize(polygon, frame, [&](int row, int begin, int end) {
    for (int col = begin; col < end; ++col) raster.at(col, row) = value;
  });
}

}  // namespace orthodrive
