#include "orthodrive/network/cubic_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

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
    sum += (i == 0 || i == steps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * length(derivative(q, static_cast<double>(i) / steps));
  return sum / (3.0 * steps);
}

}  // namespace

PlanElement cubic_part(const PlanElement& element, double p0, double p1) {
  const ParamPoly3& poly = std::get<ParamPoly3>(element.shape);
  const double c = std::cos(element.hdg), s = std::sin(element.hdg), d = p1 - p0, unit = poly.normalized ? 1.0 : element.length;
  const Cubic2 q{Vec2{element.x, element.y} + turned({poly.a_u, poly.a_v}, c, s), turned({poly.b_u, poly.b_v}, c, s) * unit,
                 turned({poly.c_u, poly.c_v}, c, s) * (unit * unit), turned({poly.d_u, poly.d_v}, c, s) * (unit * unit * unit)};
  PlanElement part = element_of({q[0] + (q[1] + (q[2] + q[3] * p0) * p0) * p0, derivative(q, p0) * d,
                                 (q[2] + q[3] * (3.0 * p0)) * (d * d), q[3] * (d * d * d)});
  part.length = element.length * std::abs(d);
  return part;
}

std::vector<PlanElement> cubic_plan(std::span<const Vec2> points, bool closed) {
  // Relative to the first point: differences of UTM coordinates lose digits. Closed lines go round three times and the
  // middle round is kept: what the ends do fades by 1 / 3.7 a point.
  const Vec2 origin = points.front();
  const std::size_t round = points.size() - 1, n = closed ? 3 * round + 1 : points.size();
  std::vector<Vec2> p;
  for (std::size_t i = 0; i < n; ++i) p.push_back(points[closed ? i % round : i] - origin);
  std::vector<double> h;
  for (std::size_t i = 0; i + 1 < n; ++i) h.push_back(distance(p[i], p[i + 1]));
  // Second derivatives m: the natural spline's tridiagonal equations, by Thomas' algorithm.
  std::vector<double> diagonal(n, 1.0);
  std::vector<Vec2> m(n);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    diagonal[i] = 2.0 * (h[i - 1] + h[i]);
    m[i] = ((p[i + 1] - p[i]) * (1.0 / h[i]) - (p[i] - p[i - 1]) * (1.0 / h[i - 1])) * 6.0;
    if (i > 1) {
      const double f = h[i - 1] / diagonal[i - 1];
      diagonal[i] -= f * h[i - 1];
      m[i] = m[i] - m[i - 1] * f;
    }
  }
  for (std::size_t i = n - 1; i-- > 1;) m[i] = (m[i] - (i + 2 < n ? m[i + 1] * h[i] : Vec2{})) * (1.0 / diagonal[i]);
  m.front() = m.back() = {};
  std::vector<PlanElement> plan;
  double s = 0.0;
  for (std::size_t i = closed ? round : 0; i + 1 < n && plan.size() < round; ++i) {
    const double l = h[i];
    const Cubic2 q{p[i], (p[i + 1] - p[i]) - (m[i] * 2.0 + m[i + 1]) * (l * l / 6.0), m[i] * (0.5 * l * l),
                   (m[i + 1] - m[i]) * (l * l / 6.0)};
    PlanElement e = element_of(q);
    e.s = s, e.x += origin.x, e.y += origin.y, e.length = arc_length(q);
    s += e.length;
    plan.push_back(e);
  }
  return plan;
}

}  // namespace orthodrive::network
