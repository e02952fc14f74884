// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/clothoid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/geo/angle.hpp"
#include "orthodrive/math/tridiagonal.hpp"

namespace orthodrive::network {
namespace {

// Gauss-Legendre quadrature with 6 points on [-1, 1] (Abramowitz and Stegun, table 25.4). Over a panel that turns by
// 0.5 rad at its sharper end's curvature its error is below 2e-12 of the panel's length, whatever the rate.
constexpr std::array<double, 6> gauss_node = {-0.9324695142031521, -0.6612093864662645, -0.2386191860831969,
                                              0.2386191860831969,  0.6612093864662645,  0.9324695142031521};
constexpr std::array<double, 6> gauss_weight = {0.1713244923791704, 0.3607615730481386, 0.4679139345726910,
                                                0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
constexpr double half_panel_turn_rad = 0.25;

/// One panel; cos and sin of the turn since its middle as Taylor polynomials, good to 1e-15 below 0.3 rad.
TangentMoments panel_moments(double heading, double curvature, double rate, double h) {
  const double half = 0.5 * h, k = curvature + rate * half, middle = heading + half * (curvature + 0.5 * rate * half);
  const double c = std::cos(middle), s = std::sin(middle);
  TangentMoments m;
  for (std::size_t i = 0; i < gauss_node.size(); ++i) {
    const double v = half * gauss_node[i], turn = v * (k + 0.5 * rate * v), t2 = turn * turn;
    const double cos_turn =
        1.0 - t2 / 2.0 * (1.0 - t2 / 12.0 * (1.0 - t2 / 30.0 * (1.0 - t2 / 56.0 * (1.0 - t2 / 90.0))));
    const double sin_turn = turn * (1.0 - t2 / 6.0 * (1.0 - t2 / 20.0 * (1.0 - t2 / 42.0 * (1.0 - t2 / 72.0))));
    const double w = half * gauss_weight[i], u = half + v;
    const Vec2 t{w * (c * cos_turn - s * sin_turn), w * (s * cos_turn + c * sin_turn)};
    m.m0 = m.m0 + t;
    m.m1 = m.m1 + t * u;
    m.m2 = m.m2 + t * (u * u);
  }
  return m;
}

/// Rows of the equations that a clothoid between two poses fulfils (end x, end y, end heading), derived by its
/// curvatures and its length, inverted: derivatives of (curvature0, curvature1) by the headings at both ends.
struct CurvatureSlopes {
  double k0_by_h0 = 0.0, k0_by_h1 = 0.0, k1_by_h0 = 0.0, k1_by_h1 = 0.0;
};

CurvatureSlopes curvature_slopes(Vec2 to, double heading0, const ClothoidFit& fit) {
  const double l = fit.length_m, k0 = fit.curvature0, k1 = fit.curvature1;
  const TangentMoments m = tangent_moments(heading0, k0, (k1 - k0) / l, l);
  const Vec2 by_k1 = left_normal(m.m2) * (0.5 / l), by_k0 = left_normal(m.m1) - by_k1, by_h0 = left_normal(to);
  const double end = heading0 + 0.5 * (k0 + k1) * l;
  const Vec2 by_l = Vec2{std::cos(end), std::sin(end)} - left_normal(m.m2) * (0.5 * (k1 - k0) / (l * l));
  // Columns k0, k1, l. Cramer's rule, by the adjugate's first two rows.
  const double a[3][3] = {{by_k0.x, by_k1.x, by_l.x}, {by_k0.y, by_k1.y, by_l.y}, {0.5 * l, 0.5 * l, 0.5 * (k0 + k1)}};
  const auto minor = [&](int r0, int r1, int c0, int c1) { return a[r0][c0] * a[r1][c1] - a[r0][c1] * a[r1][c0]; };
  const double det = a[0][0] * minor(1, 2, 1, 2) - a[0][1] * minor(1, 2, 0, 2) + a[0][2] * minor(1, 2, 0, 1);
  const double i00 = minor(1, 2, 1, 2) / det, i01 = -minor(0, 2, 1, 2) / det, i02 = minor(0, 1, 1, 2) / det;
  const double i10 = -minor(1, 2, 0, 2) / det, i11 = minor(0, 2, 0, 2) / det, i12 = -minor(0, 1, 0, 2) / det;
  return {-(i00 * by_h0.x + i01 * by_h0.y + i02), i02, -(i10 * by_h0.x + i11 * by_h0.y + i12), i12};
}

}  // namespace

TangentMoments tangent_moments(double heading, double curvature, double rate, double length_m) {
  const double turn = std::max(std::abs(curvature), std::abs(curvature + rate * length_m)) * std::abs(length_m);
  const int panels = 1 + static_cast<int>(0.5 * turn / half_panel_turn_rad);
  if (panels == 1) return panel_moments(heading, curvature, rate, length_m);
  TangentMoments sum;
  const double h = length_m / panels;
  for (int i = 0; i < panels; ++i) {
    const double a = i * h;
    const TangentMoments m = panel_moments(heading + a * (curvature + 0.5 * rate * a), curvature + rate * a, rate, h);
    sum.m0 = sum.m0 + m.m0;
    sum.m1 = sum.m1 + m.m1 + m.m0 * a;
    sum.m2 = sum.m2 + m.m2 + m.m1 * (2.0 * a) + m.m0 * (a * a);
  }
  return sum;
}

ClothoidFit fit_clothoid(Vec2 to, double heading0, double heading1) {
  const double r = length(to), chord = std::atan2(to.y, to.x);
  if (!(r > 0.0)) return {};
  const double phi0 = wrapped_angle(heading0 - chord), phi1 = wrapped_angle(heading1 - chord), delta = phi1 - phi0;
  // Heading along the unit clothoid: A t^2 + (delta - A) t + phi0; its end has y = 0. First guess: Bertolazzi and
  // Frego, eq. 20.
  const double x = phi0 / std::numbers::pi, y = phi1 / std::numbers::pi, xy = x * y, q = x * x + y * y;
  double a = (phi0 + phi1) * (2.989696028701907 + xy * (0.716228953608281 - 0.458969738821509 * xy) +
                              q * (-0.502821153340377 + xy * 0.261062141752652) - 0.045854475238709 * q * q);
  TangentMoments m;
  bool found = false;
  for (int i = 0; i < 12; ++i) {
    m = tangent_moments(phi0, delta - a, 2.0 * a, 1.0);
    if (std::abs(m.m0.y) < 1e-14) {
      found = true;
      break;
    }
    const double by_a = m.m2.x - m.m1.x;
    if (std::abs(by_a) < 1e-12) break;
    a -= std::clamp(m.m0.y / by_a, -1.0, 1.0);
  }
  if (!found) found = std::abs(m.m0.y) < 1e-12;
  if (!found || m.m0.x < 1e-3) return {};
  const double l = r / m.m0.x;
  return {(delta - a) / l, (delta + a) / l, l, true};
}

namespace {

/// The spline at the present headings: its pieces, and Newton's equations for better headings.
struct SplineEquations {
  std::vector<ClothoidFit> fit;
  std::vector<TridiagonalRow> rows;
  std::vector<double> jump;  ///< of curvature at every knot
  bool found = true;         ///< all pieces exist
};

SplineEquations equations_at(std::span<const Vec2> points, std::span<const double> h, bool closed) {
  const std::size_t n = points.size(), pieces = closed ? n : n - 1;
  SplineEquations result{std::vector<ClothoidFit>(pieces), std::vector<TridiagonalRow>(n), std::vector<double>(n, 0.0)};
  std::vector<TridiagonalRow>& rows = result.rows;
  for (std::size_t i = 0; i < pieces; ++i) {
    const std::size_t j = i + 1 < n ? i + 1 : 0;
    const Vec2 to = points[j] - points[i];
    const ClothoidFit& fit = result.fit[i] = fit_clothoid(to, h[i], h[j]);
    if (!fit.found) {
      result.found = false;
      return result;
    }
    const CurvatureSlopes d = curvature_slopes(to, h[i], fit);
    // Equation of a knot: curvature at the end of the piece before minus that at the start of the piece after it.
    const double k0 = fit.curvature0, k1 = fit.curvature1;
    result.jump[i] -= k0, result.jump[j] += k1;
    rows[i].diagonal -= d.k0_by_h0, rows[i].above -= d.k0_by_h1;
    rows[j].below += d.k1_by_h0, rows[j].diagonal += d.k1_by_h1;
    if (!closed && (i == 0 || i + 1 == pieces)) {  // the ends: no change of curvature along the piece
      if (i + 1 == pieces) {
        result.jump[j] = k1 - k0;
        rows[j] = {d.k1_by_h0 - d.k0_by_h0, d.k1_by_h1 - d.k0_by_h1, 0.0, 0.0};
      }
      if (i == 0) {
        result.jump[i] = k1 - k0;
        rows[i] = {0.0, d.k1_by_h0 - d.k0_by_h0, d.k1_by_h1 - d.k0_by_h1, 0.0};
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) rows[i].right = -result.jump[i];
  return result;
}

/// Jumps count by the turn that they mean over the piece beside them, so that no scale of the line matters.
double square_sum(const SplineEquations& equations) {
  double sum = 0.0;
  for (std::size_t i = 0; i < equations.jump.size(); ++i) {
    const double l = equations.fit[std::min(i, equations.fit.size() - 1)].length_m;
    sum += equations.jump[i] * equations.jump[i] * l * l;
  }
  return sum;
}

double largest(std::span<const double> values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

ClothoidSpline spline_of(std::span<const Vec2> points, std::span<const double> h, std::span<const ClothoidFit> fit) {
  ClothoidSpline spline{.found = true};
  for (const ClothoidFit& piece : fit) spline.length_m.push_back(piece.length_m);
  for (std::size_t i = 0; i < points.size(); ++i)
    spline.knots.push_back({points[i], h[i], i < fit.size() ? fit[i].curvature0 : fit[i - 1].curvature1});
  return spline;
}

}  // namespace

ClothoidSpline clothoid_spline(std::span<const Vec2> points, std::span<const double> headings, bool closed) {
  constexpr int max_iterations = 40;
  const std::size_t n = points.size();
  std::vector<double> h(headings.begin(), headings.end()), last(n), step(n);
  double before = 0.0, scale = 1.0;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    SplineEquations equations = equations_at(points, h, closed);
    const double sum = equations.found ? square_sum(equations) : INFINITY;
    const bool better = iteration == 0 || sum <= before * (1.0 + 1e-9) || sum < 1e-18;
    if (!std::isfinite(sum) || !better) {  // half a step back
      scale *= 0.5;
      if (iteration == 0 || scale < 1e-3) return {};
      for (std::size_t i = 0; i < n; ++i) h[i] = last[i] + scale * step[i];
      continue;
    }
    const double jump = largest(equations.jump);
    if (jump < 1e-12 || (jump < 1e-9 && sum > 0.01 * before && iteration > 0))
      return spline_of(points, h, equations.fit);
    before = sum, last = h;
    if (n == 2 && !closed) {  // one piece: both equations are the same; the arc that leaves in the first heading
      const Vec2 to = points[1] - points[0];
      h[1] = h[0] + 2.0 * wrapped_angle(std::atan2(to.y, to.x) - h[0]);
      continue;
    }
    step = solve_tridiagonal(std::move(equations.rows), closed);
    const double widest = largest(step);
    if (!std::isfinite(widest)) return {};
    scale = std::min(1.0, 0.5 / std::max(widest, 1e-300));
    for (std::size_t i = 0; i < n; ++i) h[i] += scale * step[i];
  }
  return {};
}

}  // namespace orthodrive::network
