// SPDX-License-Identifier: Apache-2.0
#pragma once
// Constrained Delaunay triangulation by CGAL, refined until its triangles keep to a surface.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::scene {

struct Triangulation {
  std::vector<Vec2> points;                             ///< those given, then those added
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise, sorted, of the convex hull of the points
  std::vector<std::uint32_t> regions;  ///< one a triangle: parts of the plane between the constraints, from 0
  std::vector<Vec2> region_points;     ///< well inside each region: the centre of its largest triangle
};

/// The surface that the triangles of some regions keep to.
struct SurfaceToKeep {
  std::function<bool(Vec2)> is_kept;  ///< by a region's point; none: no region is refined
  /// Height of the surface, which must not depend on the triangulation. Nothing: none there.
  std::function<std::optional<double>(Vec2)> height_m;
  /// Whether an edge may get a point, by its ends: not on borders that others triangulate, too.
  std::function<bool(Vec2, Vec2)> may_split;
  double tolerance_m = 0.015;  ///< at the middles of edges and triangles
};

/// Points must differ from each other; constraints are pairs of indices. Predicates are exact. Points are added where
/// constraints cross and, on the plan grid relative to (0, 0), where the surface asks for them: in the middles of edges
/// and triangles that are off, but for those shorter than 10 cm. Whether an edge between two regions or of a constraint
/// is split depends on the edge alone. The result does not depend on the order of the points.
[[nodiscard]] Triangulation triangulate(std::span<const Vec2> points,
                                        std::span<const std::array<std::uint32_t, 2>> constraints,
                                        const SurfaceToKeep& surface = {});

}  // namespace orthodrive::scene
