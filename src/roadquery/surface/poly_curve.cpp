// SPDX-License-Identifier: Apache-2.0
#include "roadquery/surface/poly_curve.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace roadquery {
namespace {

// Gauss-Legendre quadrature with 8 points, as in road_surface.cpp: nodes and weights of the positive half.
constexpr std::array<double, 4> arc_nodes = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                             0.9602898564975363};
constexpr std::array<double, 4> arc_weights = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                               0.1012285362903763};
constexpr std::size_t arc_panels = 8;  // of the whole curve: exact to rounding where its speed varies tenfold

double speed_at(const ParamPoly3& q, double p) {
  return std::hypot(q.b_u + p * (2.0 * q.c_u + p * 3.0 * q.d_u), q.b_v + p * (2.0 * q.c_v + p * 3.0 * q.d_v));
}

/// Length of the curve between two parameters; negative backwards.
double arc_between(const ParamPoly3& q, double p0, double p1) {
  const double middle = 0.5 * (p0 + p1), half = 0.5 * (p1 - p0);
  double sum = 0.0;
  for (std::size_t i = 0; i < arc_nodes.size(); ++i)
    sum += arc_weights[i] * (speed_at(q, middle - half * arc_nodes[i]) + speed_at(q, middle + half * arc_nodes[i]));
  return half * sum;
}

double last_parameter(const PlanElement& e, const ParamPoly3& q) { return q.normalized ? 1.0 : e.length; }

/// Lengths of the curve up to the ends of its panels.
std::array<double, arc_panels + 1> arc_table(const ParamPoly3& q, double p_end) {
  std::array<double, arc_panels + 1> arcs{};
  const double step = p_end / static_cast<double>(arc_panels);
  for (std::size_t i = 0; i < arc_panels; ++i)
    arcs[i + 1] = arcs[i] + arc_between(q, step * static_cast<double>(i), step * static_cast<double>(i + 1));
  return arcs;
}

/// The parameter at `arc` metres behind the one at p0; [p0, p1] is `panel_m` long and holds it, but beyond the curve's
/// ends. Newton's method.
double parameter_at(const ParamPoly3& q, double p0, double p1, double panel_m, double arc) {
  constexpr int most_steps = 20;
  double p = p0 + (p1 - p0) * (panel_m > 0.0 ? arc / panel_m : 0.0);
  const double reach = p1 - p0, low = std::min(p0, p) - reach, high = std::max(p1, p) + reach;
  for (int i = 0; i < most_steps; ++i) {
    const double speed = speed_at(q, p), miss = arc - arc_between(q, p0, p);
    if (!(speed > 0.0) || !(std::abs(miss) > 1e-13 * panel_m)) break;
    p = std::clamp(p + miss / speed, low, high);
  }
  return p;
}

constexpr std::size_t terms = 6;  // of powers 0 to 5
using Series = std::array<double, terms>;

Series product(const Series& a, const Series& b) {
  Series sum{};
  for (std::size_t i = 0; i < terms; ++i)
    for (std::size_t k = 0; i + k < terms; ++k) sum[i + k] += a[i] * b[k];
  return sum;
}

/// polynomial(x) of a series x.
template <std::size_t count>
Series composed(const std::array<double, count>& polynomial, const Series& x) {
  Series sum{};
  for (std::size_t i = count; i-- > 0;) {
    sum = product(sum, x);
    sum[0] += polynomial[i];
  }
  return sum;
}

/// x^(-1/2), by the recurrence for powers of series (Knuth, The Art of Computer Programming 2, 4.7).
Series inverse_root_of(const Series& x) {
  constexpr double power = -0.5;
  Series root{};
  root[0] = 1.0 / std::sqrt(x[0]);
  for (std::size_t n = 1; n < terms; ++n) {
    double sum = 0.0;
    for (std::size_t k = 1; k <= n; ++k)
      sum += ((power + 1.0) * static_cast<double>(k) - static_cast<double>(n)) * x[k] * root[n - k];
    root[n] = sum / (static_cast<double>(n) * x[0]);
  }
  return root;
}

}  // namespace

double curve_length(const PlanElement& element, const ParamPoly3& poly) {
  return arc_table(poly, last_parameter(element, poly)).back();
}

PolyPlace place_along(const PlanElement& element, const ParamPoly3& poly, double ds) {
  const double p_end = last_parameter(element, poly);
  if (!(element.length > 0.0)) return {0.0, 1.0};
  const auto arcs = arc_table(poly, p_end);
  const double stretch = arcs.back() / element.length;
  if (!(stretch > 0.0) || !std::isfinite(stretch)) return {ds * p_end / element.length, stretch};
  const double arc = ds * stretch;
  std::size_t panel = 0;
  while (panel + 1 < arc_panels && arc > arcs[panel + 1]) ++panel;
  const double step = p_end / static_cast<double>(arc_panels), p0 = step * static_cast<double>(panel);
  return {parameter_at(poly, p0, p0 + step, arcs[panel + 1] - arcs[panel], arc - arcs[panel]), stretch};
}

ParamPoly3 from_poly3(const Cubic& v_of_u, double length_m) {
  ParamPoly3 q{0.0, 1.0, 0.0, 0.0, v_of_u.a, v_of_u.b, v_of_u.c, v_of_u.d, false};
  double u = length_m / std::hypot(1.0, v_of_u.b);
  for (int i = 0; i < 50; ++i) {  // Newton: the speed along u is 1 at least
    const double miss = length_m - arc_table(q, u).back();
    if (!(std::abs(miss) > 1e-12 * length_m)) break;
    u = std::clamp(u + miss / speed_at(q, u), 0.0, length_m);
  }
  return {0.0, u, 0.0, 0.0, q.a_v, q.b_v * u, q.c_v * u * u, q.d_v * u * u * u, true};
}

PolySeries series_around(const ParamPoly3& poly, const PolyPlace& place, double turn_rad) {
  const double p = place.p;
  const std::array<double, 4> u = {0.0, poly.b_u + p * (2.0 * poly.c_u + p * 3.0 * poly.d_u),
                                   poly.c_u + 3.0 * p * poly.d_u, poly.d_u};
  const std::array<double, 4> v = {0.0, poly.b_v + p * (2.0 * poly.c_v + p * 3.0 * poly.d_v),
                                   poly.c_v + 3.0 * p * poly.d_v, poly.d_v};
  const std::array<double, 3> du = {u[1], 2.0 * u[2], 3.0 * u[3]}, dv = {v[1], 2.0 * v[2], 3.0 * v[3]};
  std::array<double, 5> square{};  // of the speed
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) square[i + k] += du[i] * du[k] + dv[i] * dv[k];
  // dq/ds = stretch / speed(q): each round makes one more term of q right.
  Series q{};
  for (std::size_t round = 1; round < terms; ++round) {
    const Series rate = inverse_root_of(composed(square, q));
    for (std::size_t i = 1; i < terms; ++i) q[i] = place.stretch * rate[i - 1] / static_cast<double>(i);
  }
  const Series at_u = composed(u, q), at_v = composed(v, q);
  const double c = std::cos(turn_rad), n = std::sin(turn_rad);
  PolySeries series;
  for (std::size_t i = 1; i < terms; ++i) {
    series.along[i - 1] = c * at_u[i] + n * at_v[i];
    series.left[i - 1] = c * at_v[i] - n * at_u[i];
  }
  return series;
}

}  // namespace roadquery
