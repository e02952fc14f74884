// SPDX-License-Identifier: Apache-2.0
// See fit_plan.hpp for the method; docs/measured/network.md for what it reaches. The biarc is that of K. M. Bolton,
// Biarc curves, Computer-Aided Design 7 (1975), in closed form: the joint lies where both control lengths d are equal,
// d being the root of
//   |v|^2 - 2 d v.(t1 + t2) + 2 d^2 (t1.t2 - 1) = 0.

#include "orthodrive/network/curves/fit_plan.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <optional>

#include "orthodrive/geo/angle.hpp"
#include "orthodrive/network/curves/clothoid_chain.hpp"
#include "orthodrive/network/curves/cubic_plan.hpp"
#include "orthodrive/network/curves/smooth_points.hpp"
#include "roadquery/surface/poly_curve.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Arc;
using roadquery::Line;
using roadquery::ParamPoly3;
using roadquery::PlanElement;
using roadquery::Spiral;

// Waves shorter than this are noise of the nodes: refined roads have nodes every 2 m that err together over some 10 m.
constexpr double cutoff_m = 20.0;
// Knots of the first line, dense enough for any road: they are taken out again where they are not needed.
constexpr double first_spacing_m = 10.0;
constexpr double first_turn_rad = 0.3;
constexpr double first_min_spacing_m = 0.6;
constexpr int max_start_rounds = 8;  // each puts knots in where the line is still too far from its nodes

Vec2 unit(double heading) { return {std::cos(heading), std::sin(heading)}; }

double curvature_of(const PlanElement& e) {
  const Arc* arc = std::get_if<Arc>(&e.shape);
  return arc ? arc->curvature : 0.0;
}

/// Circle arc that leaves `from` in its direction and ends at `end`; a line when it bends by less than shows.
PlanElement arc_to(const Pose& from, Vec2 end) {
  const Vec2 chord = end - from.p;
  const double n = length(chord), turn = 2.0 * std::atan2(cross(from.direction, chord), dot(from.direction, chord));
  PlanElement e{.x = from.p.x, .y = from.p.y, .hdg = std::atan2(from.direction.y, from.direction.x), .length = n};
  if (std::abs(turn) > 1e-8 && std::abs(turn) * n > 1e-7) {
    e.length = n * (0.5 * turn) / std::sin(0.5 * turn);
    e.shape = Arc{turn / e.length};
  } else {
    e.hdg = std::atan2(chord.y, chord.x);
  }
  return e;
}

/// Nodes at which the first line has its knots, ascending; first and last for open lines.
std::vector<std::size_t> choose_knots(std::span<const Vec2> q, bool closed, std::span<const char> wanted) {
  const std::size_t n = q.size();
  std::vector<std::size_t> at{0};
  double walked = 0.0, turned = 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    const double step = distance(q[i - 1], q[i]);
    walked += step;
    const bool end = !closed && i + 1 == n;
    const Vec2 in = q[i] - q[i - 1], out = q[i + 1 < n ? i + 1 : (closed ? 0 : i)] - q[i];
    const double turn = end ? 0.0 : std::abs(std::atan2(cross(in, out), dot(in, out)));
    turned += turn;
    const bool far = walked >= first_spacing_m || turned >= first_turn_rad || wanted[i];
    if (!end && (!far || walked < first_min_spacing_m)) continue;
    // A last piece too short for its neighbours joins the one before.
    if (end && walked < first_min_spacing_m && at.size() > 1) at.pop_back();
    at.push_back(i);
    walked = turned = 0.0;
  }
  if (closed && at.size() > 3 && distance(q[at.back()], q[0]) < first_min_spacing_m) at.pop_back();
  return at;
}

/// Tangent at b of the circle through a, b, c: exact on circles for any spacing.
Vec2 circle_tangent(Vec2 a, Vec2 b, Vec2 c) {
  const Vec2 in = b - a, out = c - b;
  const double l1 = dot(in, in), l2 = dot(out, out);
  if (l1 <= 0.0 || l2 <= 0.0) return normalized(c - a);
  const Vec2 t = normalized(in * (1.0 / l1) + out * (1.0 / l2));
  return length(t) > 0.0 ? t : normalized(out);
}

ClothoidSpline first_line(std::span<const Vec2> q, std::span<const std::size_t> at, bool closed) {
  const std::size_t n = at.size();
  std::vector<Vec2> points;
  points.reserve(at.size());
  for (const std::size_t i : at) points.push_back(q[i]);
  std::vector<double> headings;
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = i == 0 && !closed, last = i + 1 == n && !closed;
    Vec2 t;
    if (n == 2)
      t = points[1] - points[0];
    else if (first) {
      const Vec2 inner = circle_tangent(points[0], points[1], points[2]), c = normalized(points[1] - points[0]);
      t = c * (2.0 * dot(inner, c)) - inner;
    } else if (last) {
      const Vec2 inner = circle_tangent(points[n - 3], points[n - 2], points[n - 1]),
                 c = normalized(points[n - 1] - points[n - 2]);
      t = c * (2.0 * dot(inner, c)) - inner;
    } else {
      t = circle_tangent(points[(i + n - 1) % n], points[i], points[(i + 1) % n]);
    }
    headings.push_back(std::atan2(t.y, t.x));
  }
  return clothoid_spline(points, headings, closed);
}

/// Clothoids through some nodes of the smoothed line, dense enough for all nodes to lie near.
std::optional<ClothoidChain> start_line(std::span<const Vec2> nodes, bool closed, const ChainLimits& limits) {
  const std::vector<Vec2> q = smooth_points(nodes, closed, cutoff_m, 0.6 * limits.tolerance_m);
  std::optional<ClothoidChain> chain;
  std::vector<char> wanted(nodes.size(), 0);
  for (int round = 0; round < max_start_rounds; ++round) {
    const std::vector<std::size_t> at = choose_knots(q, closed, wanted);
    const ClothoidSpline spline = first_line(q, at, closed);
    if (!spline.found) break;
    chain.emplace(nodes, closed, spline, at, limits);
    // A knot more at the farthest node of every element that leaves its nodes.
    const std::vector<ClothoidChain::Foot> feet = chain->feet();
    bool near = true;
    for (std::size_t i = 0; i < feet.size();) {
      std::size_t worst = i, j = i;
      for (; j < feet.size() && feet[j].element == feet[i].element; ++j)
        if (feet[j].distance_m > feet[worst].distance_m) worst = j;
      if (feet[worst].distance_m > 0.8 * limits.tolerance_m && !wanted[worst]) wanted[worst] = 1, near = false;
      i = j;
    }
    if (near) break;
  }
  return chain;
}

/// The circle near all nodes of a closed line, if there is one: two arcs.
std::optional<PlanFit> circle_fit(std::span<const Vec2> nodes, Vec2 origin, double tolerance_m) {
  // Least squares for x^2 + y^2 = 2 a x + 2 b y + c (Kasa 1976), about the mean.
  const auto n = static_cast<double>(nodes.size());
  Vec2 mean;
  for (const Vec2 p : nodes) mean = mean + p * (1.0 / n);
  double xx = 0.0, xy = 0.0, yy = 0.0, rx = 0.0, ry = 0.0, r2 = 0.0;
  for (const Vec2 p : nodes) {
    const Vec2 d = p - mean;
    const double q = dot(d, d);
    xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y, rx += d.x * q, ry += d.y * q, r2 += q / n;
  }
  const double det = xx * yy - xy * xy;
  if (!(det > 1e-9 * xx * yy)) return std::nullopt;
  const Vec2 shift{0.5 * (rx * yy - ry * xy) / det, 0.5 * (ry * xx - rx * xy) / det}, center = mean + shift;
  const double radius = std::sqrt(r2 + dot(shift, shift));
  PlanFit fit;
  double turn = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (std::abs(distance(nodes[i], center) - radius) > tolerance_m) return std::nullopt;
    fit.point_s.push_back(std::abs(turn) * radius);
    const Vec2 a = nodes[i] - center, b = nodes[i + 1 < nodes.size() ? i + 1 : 0] - center;
    turn += std::atan2(cross(a, b), dot(a, b));
  }
  if (std::abs(std::abs(turn) - 2.0 * std::numbers::pi) > 1e-6) return std::nullopt;
  const double side = turn > 0.0 ? 1.0 : -1.0, half = std::numbers::pi * radius;
  const Vec2 out = normalized(nodes[0] - center) * radius;
  for (const double sign : {1.0, -1.0}) {
    const Vec2 p = center + out * sign + origin, t = left_normal(out) * (side * sign);
    fit.elements.push_back({sign > 0.0 ? 0.0 : half, p.x, p.y, std::atan2(t.y, t.x), half, Arc{side / radius}});
  }
  for (std::size_t i = 1; i < fit.point_s.size(); ++i) fit.point_s[i] = std::max(fit.point_s[i], fit.point_s[i - 1]);
  fit.point_s.push_back(2.0 * half);
  return fit;
}

PlanFit cubic_fit(std::span<const Vec2> points, bool closed) {
  PlanFit fit;
  fit.elements = cubic_plan(points, closed);
  for (const PlanElement& e : fit.elements) fit.point_s.push_back(e.s);
  fit.point_s.push_back(plan_length(fit.elements));
  fit.clothoids = false;
  return fit;
}

/// Curvatures that differ by less than a file or a reader can tell are one: SUMO drops spirals whose ends are the same,
/// CommonRoad refuses a file for one whose ends differ by 1.35e-6 1/m. The arc of the mean curvature ends
/// change length^2 / 12 to the side of the spiral, so it is turned back by change length / 12 and ends in its place.
void set_shape(double curvature0, double curvature1, PlanElement& e) {
  const double change = curvature1 - curvature0, turn = change * e.length / 12.0;
  constexpr double least_change = 2e-6, most_turn_rad = 4.5e-7;  // two of them meet at a joint
  const double mean = 0.5 * (curvature0 + curvature1);
  if (std::abs(change) > least_change || std::abs(turn) > most_turn_rad)
    e.shape = Spiral{curvature0, curvature1};
  else if (mean != 0.0)
    e.shape = Arc{mean}, e.hdg = wrapped_angle(e.hdg - turn);
  else
    e.shape = Line{}, e.hdg = wrapped_angle(e.hdg - turn);
}

PlanElement element_of(const ClothoidChain::Element& element, double s, Vec2 origin) {
  PlanElement e{.s = s,
                .x = element.start.p.x + origin.x,
                .y = element.start.p.y + origin.y,
                .hdg = wrapped_angle(element.start.heading_rad),
                .length = element.length_m};
  if (element.kind == ElementKind::arc) e.shape = Arc{element.start.curvature};
  if (element.kind == ElementKind::clothoid) set_shape(element.start.curvature, element.end_curvature, e);
  return e;
}

void measure(PlanFit& fit, std::span<const Vec2> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double off = distance(pose_at(fit.elements, fit.point_s[i]).p, points[i]);
    fit.mean_deviation_m += off / static_cast<double>(points.size());
    if (off > fit.max_deviation_m) fit.max_deviation_m = off, fit.farthest_point = i;
  }
}

PlanElement line_through(Vec2 a, Vec2 b) {
  const Vec2 d = b - a;
  return {.x = a.x, .y = a.y, .hdg = std::atan2(d.y, d.x), .length = length(d)};
}

}  // namespace

std::vector<PlanElement> biarc(const Pose& from, const Pose& to) {
  const Vec2 v = to.p - from.p, t = from.direction + to.direction;
  const double vt = dot(v, t), denominator = 2.0 * (1.0 - dot(from.direction, to.direction));
  const double d = denominator > 1e-12 ? (-vt + std::sqrt(vt * vt + denominator * dot(v, v))) / denominator
                                       : dot(v, v) / (2.0 * std::max(vt, 1e-12));
  if (d > 100.0 * length(v)) {
    // (Nearly) equal directions and the target at right angles or behind: the arcs would be huge. Turn round half-way.
    const Pose middle{(from.p + to.p) * 0.5, normalized(t) * -1.0};
    std::vector<PlanElement> loop = biarc(from, middle);
    const double start = plan_length(loop);
    for (PlanElement e : biarc(middle, to)) {
      e.s += start;
      loop.push_back(e);
    }
    return loop;
  }
  const Vec2 joint = (from.p + to.p + (from.direction - to.direction) * d) * 0.5;
  std::vector<PlanElement> elements{arc_to(from, joint)};
  // The second arc from its far end: it arrives exactly at `to` in its direction.
  std::vector<PlanElement> back{arc_to({to.p, to.direction * -1.0}, joint)};
  const PlanElement second = reverse_plan(back).front();
  const double k0 = curvature_of(elements[0]), k1 = curvature_of(second), l = elements[0].length + second.length;
  if (std::abs(k1 - k0) * l * std::max(1.0, l) < 1e-8 && std::abs(k0 * l) < std::numbers::pi) {
    elements[0].length = l;
  } else {
    elements.push_back(second);
    elements[1].s = elements[0].length;
    // A tangent along the chord leaves one of the arcs without length.
    constexpr double no_length_m = 1e-9;
    if (elements[0].length < no_length_m) {
      elements.erase(elements.begin());
      elements[0].s = 0.0;
    } else if (second.length < no_length_m) {
      elements.pop_back();
    }
  }
  return elements;
}

std::vector<PlanElement> turn(const Pose& from, const Pose& to) {
  const auto heading = [](const Pose& pose) { return std::atan2(pose.direction.y, pose.direction.x); };
  std::vector<PlanElement> arcs = biarc(from, to);
  const ClothoidFit fit = fit_clothoid(to.p - from.p, heading(from), heading(to));
  if (!fit.found || fit.length_m > 1.5 * plan_length(arcs)) return arcs;
  const double sharpest = std::max(std::abs(fit.curvature0), std::abs(fit.curvature1));
  if (std::none_of(arcs.begin(), arcs.end(),
                   [&](const PlanElement& e) { return 2.0 * std::abs(curvature_of(e)) >= sharpest; }))
    return arcs;
  PlanElement e{.x = from.p.x, .y = from.p.y, .hdg = heading(from), .length = fit.length_m};
  set_shape(fit.curvature0, fit.curvature1, e);
  return {e};
}

double plan_length(std::span<const PlanElement> plan) {
  return plan.empty() ? 0.0 : plan.back().s + plan.back().length;
}

Pose pose_at(std::span<const PlanElement> plan, double s) {
  assert(!plan.empty());
  const auto next =
      std::upper_bound(plan.begin() + 1, plan.end(), s, [](double a, const PlanElement& e) { return a < e.s; });
  const PlanElement& e = *(next - 1);
  const roadquery::PlanPoint q = roadquery::evaluate(e, std::clamp(s - e.s, 0.0, e.length));
  return {{q.x, q.y}, unit(q.hdg)};
}

std::vector<PlanElement> slice_plan(std::span<const PlanElement> plan, double s0, double s1) {
  constexpr double sliver_m = 1e-7;  // shorter elements are left out: the gap stays below a micrometre
  std::vector<PlanElement> result;
  for (const PlanElement& e : plan) {
    const double a = std::max(s0, e.s), b = std::min(s1, e.s + e.length);
    if (b - a < sliver_m) continue;
    const double u = (a - e.s) / e.length, v = (b - e.s) / e.length;
    PlanElement part;
    if (const ParamPoly3* poly = std::get_if<ParamPoly3>(&e.shape)) {
      const double range = poly->normalized ? 1.0 : e.length;
      part = cubic_part(e, roadquery::place_along(e, *poly, a - e.s).p / range,
                        roadquery::place_along(e, *poly, b - e.s).p / range);
    } else {
      const roadquery::PlanPoint q = roadquery::evaluate(e, a - e.s);
      part = {0.0, q.x, q.y, wrapped_angle(q.hdg), b - a, e.shape};
      if (const Spiral* spiral = std::get_if<Spiral>(&e.shape)) {  // weighted means: exact at both ends
        const auto [k0, k1] = *spiral;
        set_shape(k0 * (1.0 - u) + k1 * u, k0 * (1.0 - v) + k1 * v, part);
      }
    }
    part.s = result.empty() ? 0.0 : plan_length(result);
    part.length = b - a;
    result.push_back(part);
  }
  return result;
}

std::vector<PlanElement> reverse_plan(std::span<const PlanElement> plan) {
  std::vector<PlanElement> result;
  for (auto it = plan.rbegin(); it != plan.rend(); ++it) {
    PlanElement e;
    if (std::holds_alternative<ParamPoly3>(it->shape)) {
      e = cubic_part(*it, 1.0, 0.0);
    } else {
      const roadquery::PlanPoint q = roadquery::evaluate(*it, it->length);
      e = {0.0, q.x, q.y, wrapped_angle(q.hdg + std::numbers::pi), it->length, it->shape};
      if (Arc* arc = std::get_if<Arc>(&e.shape)) arc->curvature = -arc->curvature;
      if (Spiral* spiral = std::get_if<Spiral>(&e.shape)) *spiral = {-spiral->curvature_end, -spiral->curvature_start};
    }
    e.s = plan_length(result);
    result.push_back(e);
  }
  return result;
}

PlanFit fit_plan(std::span<const Vec2> points, const FitPlanOptions& options) {
  assert(points.size() >= 2);
  PlanFit fit;
  fit.point_s.assign(points.size(), 0.0);
  // Differences of UTM coordinates lose digits: work relative to the first point.
  const Vec2 origin = points.front();
  std::vector<Vec2> local;
  local.reserve(points.size());
  for (const Vec2 p : points) local.push_back(p - origin);
  if (options.closed) local.pop_back();
  if (local.size() < 3) {
    fit.elements = {line_through(points.front(), points[1])};
    fit.point_s.back() = fit.elements[0].length;
    return fit;
  }
  if (options.closed)
    if (std::optional<PlanFit> circle = circle_fit(local, origin, options.tolerance_m)) {
      measure(*circle, points);
      return *circle;
    }
  const ChainLimits limits{
      .tolerance_m = 0.999 * options.tolerance_m,  // measured across the line, stated to the foot
      .max_curvature_rate = options.max_curvature_rate,
      .max_curvature = options.max_curvature.first(std::min(local.size(), options.max_curvature.size()))};
  std::optional<ClothoidChain> chain = start_line(local, options.closed, limits);
  if (!chain) return cubic_fit(points, options.closed);
  chain->remove_knots(1);
  chain->snap_kinds();
  chain->remove_knots(1);
  chain->polish();

  double s = 0.0;
  std::vector<double> begin;
  for (const ClothoidChain::Element& element : chain->elements()) {
    fit.elements.push_back(element_of(element, s, origin));
    begin.push_back(s);
    s += element.length_m;
  }
  // The plan begins beside the first node and ends beside the last one.
  const std::vector<ClothoidChain::Foot> feet = chain->feet();
  const auto foot_s = [&](std::size_t i) { return begin[feet[i].element] + feet[i].ds_m; };
  const double seam = foot_s(0), end = options.closed ? seam + s : foot_s(feet.size() - 1);
  if (seam > 0.0 || end < s) {
    for (std::size_t i = 0; options.closed && i < begin.size(); ++i) {
      fit.elements.push_back(PlanElement(fit.elements[i]));
      fit.elements.back().s += s;
    }
    fit.elements = slice_plan(fit.elements, seam, end);
  }
  const double length = plan_length(fit.elements);
  for (std::size_t i = 0; i < feet.size(); ++i) {
    double at_s = foot_s(i) - seam;
    if (at_s < 0.0) at_s += s;
    fit.point_s[i] = i == 0 ? 0.0 : std::clamp(at_s, fit.point_s[i - 1], length);
  }
  fit.point_s.back() = length;
  measure(fit, points);
  return fit;
}

}  // namespace orthodrive::network
