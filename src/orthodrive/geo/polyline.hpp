// SPDX-License-Identifier: Apache-2.0
#pragma once
// Polylines as values.

#include <span>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

using Polyline = std::vector<Vec2>;

[[nodiscard]] double length_m(std::span<const Vec2> line);
/// Distance along the line of every point; first is 0.
[[nodiscard]] std::vector<double> arc_lengths_m(std::span<const Vec2> line);
/// Unit tangents at the points: the direction of the bisector inside, of the only segment at the ends.
/// Repeated points get the tangent of their neighbourhood.
[[nodiscard]] std::vector<Vec2> tangents(std::span<const Vec2> line);
/// Where two lines side by side at distance 1 from theirs meet, for the unit normals of both: their mitre. The first
/// normal where that would be further out than twice the distance.
[[nodiscard]] Vec2 mitre(Vec2 normal_before, Vec2 normal_behind);
/// Point at distance s along the line, clamped to its ends. The line needs at least one point.
[[nodiscard]] Vec2 point_at(std::span<const Vec2> line, double s_m);

struct LineProjection {
  double s_m = 0.0;         ///< along the line
  double offset_m = 0.0;    ///< signed: positive to the left of the line
  double distance_m = 0.0;  ///< >= |offset| beyond the ends
  std::size_t segment = 0;
  Vec2 point;  ///< on the line
};
/// Nearest point of the line. The line needs at least two points.
[[nodiscard]] LineProjection project_onto(std::span<const Vec2> line, Vec2 p);

/// Strip between the line shifted by +left and by -right (one value a point), as a ring. Not cleaned of self crossings.
[[nodiscard]] Ring strip_ring(std::span<const Vec2> line, std::span<const double> left_m,
                              std::span<const double> right_m);

}  // namespace orthodrive
