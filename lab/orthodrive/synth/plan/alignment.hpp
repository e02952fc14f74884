// SPDX-License-Identifier: Apache-2.0
#pragma once
// Exact road geometry: straights, arcs and Euler spirals as one kind of element whose curvature is linear in s.
// Surveyed lines, which were not built of such elements, are cubic splines through their points.

#include <vector>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/vec.hpp"
#include "orthodrive/math/cubic_spline.hpp"

namespace orthodrive::synth {

/// Curvature goes linearly from k_begin to k_end: both 0 = straight, equal = arc, else clothoid.
struct AlignmentElement {
  double s_m = 0.0;  ///< of its start along the alignment
  double length_m = 0.0;
  Vec2 start;
  double heading_rad = 0.0;
  double k_begin_1pm = 0.0, k_end_1pm = 0.0;
};

/// Splines of both coordinates over the chord length; s of the knots along the curve itself.
struct SplineCurve {
  CubicSpline x, y;
  std::vector<double> s_m;
};

/// G2 continuous: position, heading and curvature agree where elements meet (and at the seam of a closed one).
struct Alignment {
  std::vector<AlignmentElement> elements;  ///< empty when `curve` is the line
  SplineCurve curve;
  double length_m = 0.0;
  bool closed = false;
};

struct AlignmentPoint {
  Vec2 p;
  double heading_rad = 0.0;
  double curvature_1pm = 0.0;  ///< positive = left turn
};

/// Point of one element, ds from its start. Gauss-Legendre quadrature of (cos, sin) of the heading; error < 1e-10 m.
[[nodiscard]] AlignmentPoint evaluate(const AlignmentElement& element, double ds_m);
/// Clamped to the ends; closed alignments wrap around.
[[nodiscard]] AlignmentPoint evaluate(const Alignment& alignment, double s_m);

/// The curvature that a road is banked for. Designed alignments: their own. Surveyed ones: the mean over 40 m, because
/// lines through points 5 m apart that are right to a decimetre wiggle (at the Red Bull Ring by 0.02 / m in 5 m).
[[nodiscard]] double design_curvature_1pm(const Alignment& alignment, double s_m);

/// A corner of the tangent polygon and the radius of the arc that rounds it.
struct Corner {
  Vec2 p;
  double radius_m = 50.0;
};
/// The classic design of alignments: each inner corner becomes clothoid - arc - clothoid, joined by straights.
/// Radii grow until the clothoids have 12 m and shrink where the tangents are too short. Open: the line starts at the
/// first and ends at the last corner.
[[nodiscard]] Alignment round_corners(const std::vector<Corner>& corners, bool closed);

/// The circle around a place, counter-clockwise, from its easternmost point on.
[[nodiscard]] Alignment circle(Vec2 center, double radius_m);
/// Cubic spline through points by chord length. Closed: the first point is not repeated. Needs three points, none of
/// them twice in a row.
[[nodiscard]] Alignment spline_through(std::vector<Vec2> points, bool closed);

/// Points every `step_m` or a little less, ends included.
[[nodiscard]] Polyline sample(const Alignment& alignment, double step_m);
/// s of the point of the alignment nearest to p, to 1e-9 m.
[[nodiscard]] double nearest_s(const Alignment& alignment, Vec2 p);
/// The distance at which lines of nearest_s and crossings are sampled.
constexpr double search_step_m = 2.0;
/// The same with the line sampled before, at search_step_m: for many points.
[[nodiscard]] double nearest_s(const Alignment& alignment, const Polyline& line, Vec2 p);

struct AlignmentCrossing {
  double s_a_m = 0.0, s_b_m = 0.0;
};
/// All crossings of two alignments, by s of the first; exact to 1e-9 m.
[[nodiscard]] std::vector<AlignmentCrossing> crossings(const Alignment& a, const Alignment& b);
/// The same with both lines sampled before, at search_step_m.
[[nodiscard]] std::vector<AlignmentCrossing> crossings(const Alignment& a, const Polyline& line_a, const Alignment& b,
                                                       const Polyline& line_b);

}  // namespace orthodrive::synth
