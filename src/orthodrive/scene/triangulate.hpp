#pragma once
// Constrained Delaunay triangulation by CGAL.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::scene {

struct Triangulation {
  std::vector<Vec2> points;                             ///< those given; a crossing of two constraints would add one
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise, sorted, of the convex hull of the points
  std::vector<std::uint32_t> regions;  ///< one a triangle: parts of the plane between the constraints, from 0
  std::vector<Vec2> region_points;     ///< well inside each region: the centre of its largest triangle
};

/// Points must differ from each other; constraints are pairs of indices. Predicates are exact.
[[nodiscard]] Triangulation triangulate(std::span<const Vec2> points,
                                        std::span<const std::array<std::uint32_t, 2>> constraints);

}  // namespace orthodrive::scene
