// SPDX-License-Identifier: Apache-2.0
#pragma once
// Clothoids (Euler spirals): curves whose curvature changes linearly with their length. Lines and arcs are the cases
// without curvature or without change.
//
// Sources: E. Bertolazzi, M. Frego, G1 fitting with clothoids, Math. Meth. Appl. Sci. 38 (2015): one clothoid between
// two poses; the same, Interpolating clothoid splines with curvature continuity, ibid. 41 (2018): a chain of them
// through points. We integrate by Gauss-Legendre quadrature instead of Fresnel integrals: it needs no case distinction
// for flat pieces and gives the moments that derivatives are made of.

#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive::network {

/// A place on a curve: position, heading and curvature (1/m, positive = left turn).
struct Knot {
  Vec2 p;
  double heading_rad = 0.0, curvature = 0.0;
};

/// Integrals over a stretch of clothoid of 1, u and u^2 times the unit tangent, u being the length from where the
/// stretch begins.
struct TangentMoments {
  Vec2 m0, m1, m2;
};
/// A stretch that starts with `heading` and `curvature`, whose curvature changes by `rate` per metre. Good to 1e-12 of
/// its length for any turn.
[[nodiscard]] TangentMoments tangent_moments(double heading_rad, double curvature, double rate, double length_m);

/// The clothoid from the origin with heading0 to `to` with heading1 that turns least.
struct ClothoidFit {
  double curvature0 = 0.0, curvature1 = 0.0, length_m = 0.0;
  bool found = false;
};
[[nodiscard]] ClothoidFit fit_clothoid(Vec2 to, double heading0_rad, double heading1_rad);

/// A chain of clothoids through the points, continuous in position, heading and curvature; the curvature is constant on
/// the first and the last piece of open chains. Closed chains go on from the last point to the first, which is not
/// repeated. `curvature` of knot i is that at the start of piece i.
struct ClothoidSpline {
  std::vector<Knot> knots;
  std::vector<double> length_m;  ///< of the pieces: one less than knots, as many for closed chains
  bool found = false;            ///< Newton's method converged: curvatures agree within 1e-9 at all points
};
/// At least two points (three when closed), neighbours apart; headings to start from.
[[nodiscard]] ClothoidSpline clothoid_spline(std::span<const Vec2> points, std::span<const double> headings_rad,
                                             bool closed);

}  // namespace orthodrive::network
