// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/cubic_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "orthodrive/math/cubic_spline.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ParamPoly3;
using roadquery::PlanElement;

using Cubic2 = std::array<Vec2, 4>;  ///< a + b p + c p^2 + d p^3, p in [0, 1]

Vec2 turned(Vec2 v, double c, double s) { return {c * v.x - s * v.y, s * v.x + c * v.y}; }
Vec2 derivative(const Cubic2& q, double p) { return q[1] + q[2] * (2.0 * p) + q[3] * (3.0 * p * p); }

/// Into the frame of its own start; the length stays to be set.
PlanElement element_of(const Cubic2& q) {
  const Vec2 t = q[1];
  PlanElement e{.x = q[0].x, .y = q[0].y, .hdg = std::atan2(t.y, t.x)};
  const double c = std::cos(e.hdg), s = std::sin(e.hdg);
  const Vec2 v1{length(t), 0.0}, v2 = turned(q[2], c, -s), v3 = turned(q[3], c, -s);
  e.shape = ParamPoly3{0.0, v1.x, v2.x, v3.x, 0.0, v1.y, v2.y, v3.y, true};
  return e;
}

double arc_length(const Cubic2& q) {
  // Simpson's rule: what is missing only makes s run a little unevenly.
  constexpr int steps = 16;
  double sum = 0.0;
  for (int i = 0; i <= steps; ++i)
    sum += (i == 0 || i == steps ? 1.0
            : i % 2 == 1         ? 4.0
                                 : 2.0) *
           length(derivative(q, static_cast<double>(i) / steps));
  return sum / (3.0 * steps);
}

}  // namespace

PlanElement cubic_part(const PlanElement& element, double p0, double p1) {
  const ParamPoly3& poly = std::get<ParamPoly3>(element.shape);
  const double c = std::cos(element.hdg), s = std::sin(element.hdg), d = p1 - p0,
               unit = poly.normalized ? 1.0 : element.length;
  const Cubic2 q{Vec2{element.x, element.y} + turned({poly.a_u, poly.a_v}, c, s),
                 turned({poly.b_u, poly.b_v}, c, s) * unit, turned({poly.c_u, poly.c_v}, c, s) * (unit * unit),
                 turned({poly.d_u, poly.d_v}, c, s) * (unit * unit * unit)};
  PlanElement part = element_of({q[0] + (q[1] + (q[2] + q[3] * p0) * p0) * p0, derivative(q, p0) * d,
                                 (q[2] + q[3] * (3.0 * p0)) * (d * d), q[3] * (d * d * d)});
  part.length = element.length * std::abs(d);
  return part;
}

std::vector<PlanElement> cubic_plan(std::span<const Vec2> points, bool closed) {
  const Vec2 origin = points.front();  // differences of UTM coordinates lose digits
  std::vector<double> chord_m{0.0}, x, y;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) chord_m.push_back(chord_m.back() + distance(points[i - 1], points[i]));
    x.push_back(points[i].x - origin.x), y.push_back(points[i].y - origin.y);
  }
  const auto through = closed ? periodic_spline : natural_spline;
  const CubicSpline sx = through(chord_m, std::move(x)), sy = through(chord_m, std::move(y));
  std::vector<PlanElement> plan;
  double s = 0.0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double l = chord_m[i + 1] - chord_m[i];
    const Vec2 p{sx.values[i], sy.values[i]}, next{sx.values[i + 1], sy.values[i + 1]};
    const Vec2 m{sx.second[i], sy.second[i]}, m_next{sx.second[i + 1], sy.second[i + 1]};
    const Cubic2 q{p, (next - p) - (m * 2.0 + m_next) * (l * l / 6.0), m * (0.5 * l * l), (m_next - m) * (l * l / 6.0)};
    PlanElement e = element_of(q);
    e.s = s, e.x += origin.x, e.y += origin.y, e.length = arc_length(q);
    s += e.length;
    plan.push_back(e);
  }
  return plan;
}

}  // namespace orthodrive::network
