// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/alignment.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "orthodrive/geo/angle.hpp"
#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::synth {
namespace {
// Gauss-Legendre, 8 points on [-1, 1] (Abramowitz and Stegun, table 25.4).
constexpr std::array nodes{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
constexpr std::array weights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

/// Share of a corner's deflection that each of the two clothoids turns; the arc turns the rest.
constexpr double clothoid_share = 0.32;
/// Clothoids are at least this long where there is room: a slight corner gets a large radius, not a jerk.
constexpr double min_clothoid_m = 12.0;
/// Share of a polygon edge that a corner may use when it has a corner on its other end too.
constexpr double edge_share = 0.46;

Vec2 unit_vector(double heading) { return {std::cos(heading), std::sin(heading)}; }

/// Length of the curve between two parameters inside one piece; Gauss-Legendre over the speed.
double piece_length_m(const SplineCurve& curve, double from, double to) {
  const auto speed = [&](double u) { return std::hypot(curve.x.slope(u), curve.y.slope(u)); };
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  double sum = 0.0;
  for (std::size_t j = 0; j < nodes.size(); ++j)
    sum += weights[j] * (speed(middle - half * nodes[j]) + speed(middle + half * nodes[j]));
  return sum * half;
}

AlignmentPoint evaluate(const SplineCurve& curve, double s_m) {
  const auto it = std::upper_bound(curve.s_m.begin(), curve.s_m.end(), s_m);
  const std::size_t i =
      std::min(static_cast<std::size_t>(std::max<long>(0, it - curve.s_m.begin() - 1)), curve.s_m.size() - 2);
  const double begin = curve.x.knots[i], end = curve.x.knots[i + 1];
  double u = begin + (end - begin) * (s_m - curve.s_m[i]) / (curve.s_m[i + 1] - curve.s_m[i]);
  for (int k = 0; k < 6; ++k) {  // Newton; the speed is near 1, so the start is within millimetres
    const double step =
        (s_m - curve.s_m[i] - piece_length_m(curve, begin, u)) / std::hypot(curve.x.slope(u), curve.y.slope(u));
    u = std::clamp(u + step, begin, end);
    if (std::abs(step) < 1e-11) break;
  }
  const Vec2 d{curve.x.slope(u), curve.y.slope(u)}, dd{curve.x.bend(u), curve.y.bend(u)};
  return {{curve.x.at(u), curve.y.at(u)}, std::atan2(d.y, d.x), cross(d, dd) / std::pow(length(d), 3.0)};
}

/// Clothoid, arc, clothoid that turn by `deflection` with the arc's radius 1, starting at the origin along x.
std::vector<AlignmentElement> unit_corner(double deflection) {
  const double turn = std::abs(deflection), sign = deflection < 0.0 ? -1.0 : 1.0;
  const double spiral = 2.0 * clothoid_share * turn, arc = (1.0 - 2.0 * clothoid_share) * turn;
  std::vector<AlignmentElement> elements{{.length_m = spiral, .k_end_1pm = sign},
                                         {.length_m = arc, .k_begin_1pm = sign, .k_end_1pm = sign},
                                         {.length_m = spiral, .k_begin_1pm = sign}};
  for (std::size_t i = 1; i < elements.size(); ++i) {
    const AlignmentPoint end = evaluate(elements[i - 1], elements[i - 1].length_m);
    elements[i].start = end.p, elements[i].heading_rad = end.heading_rad;
  }
  return elements;
}
}  // namespace

AlignmentPoint evaluate(const AlignmentElement& e, double ds_m) {
  const double slope = e.length_m > 0.0 ? (e.k_end_1pm - e.k_begin_1pm) / e.length_m : 0.0;
  const auto heading = [&](double s) { return e.heading_rad + s * (e.k_begin_1pm + 0.5 * slope * s); };
  const double curvature = e.k_begin_1pm + slope * ds_m;
  if (e.k_begin_1pm == 0.0 && e.k_end_1pm == 0.0)
    return {e.start + unit_vector(e.heading_rad) * ds_m, e.heading_rad, 0.0};
  // Half a radian a panel keeps the quadrature far below a nanometre.
  const double turn = std::max(std::abs(e.k_begin_1pm), std::abs(curvature)) * std::abs(ds_m);
  const int panels = 1 + static_cast<int>(turn / 0.5);
  const double half = 0.5 * ds_m / panels;
  Vec2 p = e.start;
  for (int i = 0; i < panels; ++i) {
    const double middle = (2 * i + 1) * half;
    for (std::size_t j = 0; j < nodes.size(); ++j)
      p = p + (unit_vector(heading(middle - half * nodes[j])) + unit_vector(heading(middle + half * nodes[j]))) *
                  (weights[j] * half);
  }
  return {p, heading(ds_m), curvature};
}

AlignmentPoint evaluate(const Alignment& alignment, double s_m) {
  assert(!alignment.elements.empty() || alignment.curve.s_m.size() >= 2);
  double s = s_m;
  if (alignment.closed) {
    s = std::fmod(s, alignment.length_m);
    if (s < 0.0) s += alignment.length_m;
  }
  s = std::clamp(s, 0.0, alignment.length_m);
  if (alignment.elements.empty()) return evaluate(alignment.curve, s);
  auto it = std::upper_bound(alignment.elements.begin(), alignment.elements.end(), s,
                             [](double value, const AlignmentElement& e) { return value < e.s_m; });
  const AlignmentElement& e = it == alignment.elements.begin() ? *it : *std::prev(it);
  return evaluate(e, std::min(s - e.s_m, e.length_m));
}

double design_curvature_1pm(const Alignment& alignment, double s_m) {
  if (!alignment.elements.empty()) return evaluate(alignment, s_m).curvature_1pm;
  constexpr int steps = 8;  // 5 m: a hairpin turns by less than half a circle in one
  constexpr double half_m = 20.0;
  const double begin = alignment.closed ? s_m - half_m : std::max(0.0, s_m - half_m),
               end = alignment.closed ? s_m + half_m : std::min(alignment.length_m, s_m + half_m);
  double turn = 0.0, heading = evaluate(alignment, begin).heading_rad;
  for (int i = 1; i <= steps; ++i) {
    const double next = evaluate(alignment, begin + (end - begin) * i / steps).heading_rad;
    turn += wrapped_angle(next - heading);
    heading = next;
  }
  return turn / (end - begin);
}

Alignment round_corners(const std::vector<Corner>& corners, bool closed) {
  const std::size_t n = corners.size();
  assert(n >= (closed ? 3u : 2u));
  struct Rounded {
    double tangent_m = 0.0, radius_m = 0.0, heading_rad = 0.0;
    std::vector<AlignmentElement> shape;
  };
  std::vector<Rounded> rounded(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!closed && (i == 0 || i + 1 == n)) continue;
    const Vec2 in = corners[i].p - corners[(i + n - 1) % n].p, out = corners[(i + 1) % n].p - corners[i].p;
    const double heading = std::atan2(in.y, in.x), deflection = wrapped_angle(std::atan2(out.y, out.x) - heading);
    if (deflection == 0.0) continue;
    Rounded& r = rounded[i];
    r.heading_rad = heading;
    r.shape = unit_corner(deflection);
    const double unit_tangent = evaluate(r.shape.back(), r.shape.back().length_m).p.y / std::sin(deflection);
    const double room_in = length(in) * (!closed && i == 1 ? 0.8 : edge_share);
    const double room_out = length(out) * (!closed && i + 2 == n ? 0.8 : edge_share);
    const double wanted_m = std::max(corners[i].radius_m, min_clothoid_m / r.shape.front().length_m);
    r.radius_m = std::min(wanted_m, std::min(room_in, room_out) / unit_tangent);
    r.tangent_m = r.radius_m * unit_tangent;
  }

  Alignment alignment;
  alignment.closed = closed;
  const auto append = [&](AlignmentElement e) {
    e.s_m = alignment.length_m;
    alignment.length_m += e.length_m;
    alignment.elements.push_back(e);
  };
  const std::size_t edges = closed ? n : n - 1;
  for (std::size_t i = 0; i < edges; ++i) {
    const Vec2 from = corners[i].p, to = corners[(i + 1) % n].p, direction = normalized(to - from);
    const Rounded& next = rounded[(i + 1) % n];
    append({.length_m = distance(from, to) - rounded[i].tangent_m - next.tangent_m,
            .start = from + direction * rounded[i].tangent_m,
            .heading_rad = std::atan2(direction.y, direction.x)});
    const Vec2 origin = to - direction * next.tangent_m, normal = left_normal(direction);
    for (AlignmentElement e : next.shape) {
      e.start = origin + direction * (e.start.x * next.radius_m) + normal * (e.start.y * next.radius_m);
      e.heading_rad += next.heading_rad;
      e.length_m *= next.radius_m, e.k_begin_1pm /= next.radius_m, e.k_end_1pm /= next.radius_m;
      append(e);
    }
  }
  return alignment;
}

Alignment circle(Vec2 center, double radius_m) {
  const double k = 1.0 / radius_m, length_m = 2.0 * std::numbers::pi * radius_m;
  return {.elements = {{.length_m = length_m,
                        .start = center + Vec2{radius_m, 0.0},
                        .heading_rad = 0.5 * std::numbers::pi,
                        .k_begin_1pm = k,
                        .k_end_1pm = k}},
          .length_m = length_m,
          .closed = true};
}

Alignment spline_through(std::vector<Vec2> points, bool closed) {
  assert(points.size() >= 3);
  if (closed) points.push_back(points.front());
  std::vector<double> x, y;
  x.reserve(points.size());
  y.reserve(points.size());
  for (const Vec2 p : points) x.push_back(p.x), y.push_back(p.y);
  const std::vector<double> chord_m = arc_lengths_m(points);
  Alignment alignment{.closed = closed};
  SplineCurve& curve = alignment.curve;
  const auto through = closed ? periodic_spline : natural_spline;
  curve = {through(chord_m, std::move(x)), through(chord_m, std::move(y)), {0.0}};
  for (std::size_t i = 0; i + 1 < chord_m.size(); ++i)
    curve.s_m.push_back(curve.s_m.back() + piece_length_m(curve, chord_m[i], chord_m[i + 1]));
  alignment.length_m = curve.s_m.back();
  return alignment;
}

Polyline sample(const Alignment& alignment, double step_m) {
  const int count = std::max(1, static_cast<int>(std::ceil(alignment.length_m / step_m)));
  Polyline line;
  line.reserve(static_cast<std::size_t>(count) + 1);
  for (int i = 0; i < count; ++i) line.push_back(evaluate(alignment, alignment.length_m * i / count).p);
  line.push_back(alignment.closed ? line.front() : evaluate(alignment, alignment.length_m).p);
  return line;
}

double nearest_s(const Alignment& alignment, Vec2 p) {
  return nearest_s(alignment, sample(alignment, search_step_m), p);
}

double nearest_s(const Alignment& alignment, const Polyline& line, Vec2 p) {
  double s = project_onto(line, p).s_m;
  for (int i = 0; i < 20; ++i) {  // Newton on the along-track distance; the chord gave a start within centimetres
    const AlignmentPoint q = evaluate(alignment, s);
    const Vec2 t = unit_vector(q.heading_rad), d = p - q.p;
    const double step = dot(d, t) / (1.0 - q.curvature_1pm * dot(d, left_normal(t)));
    s += step;
    if (!alignment.closed) s = std::clamp(s, 0.0, alignment.length_m);
    if (std::abs(step) < 1e-10) break;
  }
  return s;
}

std::vector<AlignmentCrossing> crossings(const Alignment& a, const Alignment& b) {
  return crossings(a, sample(a, search_step_m), b, sample(b, search_step_m));
}

std::vector<AlignmentCrossing> crossings(const Alignment& a, const Polyline& line_a, const Alignment& b,
                                         const Polyline& line_b) {
  std::vector<AlignmentCrossing> found;
  const Box2 near_b = bounds_of(line_b).grown(search_step_m);
  for (std::size_t i = 0; i + 1 < line_a.size(); ++i) {
    if (!near_b.contains(line_a[i])) continue;
    for (std::size_t j = 0; j + 1 < line_b.size(); ++j) {
      const Vec2 da = line_a[i + 1] - line_a[i], db = line_b[j + 1] - line_b[j], r = line_b[j] - line_a[i];
      const double denominator = cross(da, db);
      if (std::abs(denominator) < 1e-9) continue;
      const double u = cross(r, db) / denominator, v = cross(r, da) / denominator;
      if (u < 0.0 || u >= 1.0 || v < 0.0 || v >= 1.0) continue;
      AlignmentCrossing c{a.length_m * (static_cast<double>(i) + u) / static_cast<double>(line_a.size() - 1),
                          b.length_m * (static_cast<double>(j) + v) / static_cast<double>(line_b.size() - 1)};
      for (int k = 0; k < 20; ++k) {  // Newton on p_a(s_a) = p_b(s_b)
        const AlignmentPoint pa = evaluate(a, c.s_a_m), pb = evaluate(b, c.s_b_m);
        const Vec2 ta = unit_vector(pa.heading_rad), tb = unit_vector(pb.heading_rad), d = pb.p - pa.p;
        const double det = cross(ta, tb);
        c.s_a_m += cross(d, tb) / det, c.s_b_m += cross(d, ta) / det;
        if (length(d) < 1e-11) break;
      }
      found.push_back(c);
    }
  }
  return found;
}

}  // namespace orthodrive::synth
