// SPDX-License-Identifier: Apache-2.0
#pragma once
// The best line between two edges: where to drive across the width of the road.

#include <vector>

#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {

/// A line that may be moved sideways, and how far.
struct LineBetweenEdges {
  bool closed = false;  ///< the last point leads to the first, which is not repeated
  Polyline reference;   ///< about evenly spaced, smooth
  std::vector<double> lower_m,
      upper_m;                   ///< least and largest offset to the left, one per point; a gap below 1 mm is widened
  std::vector<double> wanted_m;  ///< offset that is best when nothing else matters
};

/// What the line costs, per metre of it: offset a (p - wanted)^2 + curvature b k^2 + change of curvature c (dk/ds)^2,
/// and d (|k| - k_most)^2 where it bends more than that.
struct LineCosts {
  double offset = 0.0;              ///< a, 1
  double curvature_m4 = 0.0;        ///< b
  double curvature_rate_m6 = 0.0;   ///< c
  double sharp_m4 = 0.0;            ///< d
  double most_curvature_1pm = 0.0;  ///< k_most
};

/// The offsets to the left of the reference that cost least within their bounds. With b alone this is the
/// minimum-curvature line of Heilmeier, Wischnewski, Hermansdorfer, Betz, Lienkamp, Lohmann, Minimum curvature
/// trajectory planning and control for an autonomous race car, Vehicle System Dynamics 58, 2020. They solve a quadratic
/// program about the last line again and again; here the curvature is the angle at a point over the mean length of both
/// pieces with its exact derivatives (Gauss-Newton), and the bounds stay those of the reference. Throws Error when a
/// number is not finite.
[[nodiscard]] std::vector<double> best_offsets(const LineBetweenEdges& task, const LineCosts& costs);

/// Unit vectors to the left of the line's points.
[[nodiscard]] std::vector<Vec2> left_normals(const Polyline& line, bool closed);

/// Curvature at the middle of three points: angle over length, 1/m, positive = left turn; 0 where two of them are one.
[[nodiscard]] double curvature_of(Vec2 before, Vec2 at, Vec2 after);

}  // namespace orthodrive
