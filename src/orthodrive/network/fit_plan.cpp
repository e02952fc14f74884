// Based on: K. M. Bolton, Biarc curves, Computer-Aided Design 7 (1975); closed form as in R. N. Goldman's and
// J. Stepanyan's notes: the joint lies where both control lengths d are equal, d being the root of
//   |v|^2 - 2 d v.(t1 + t2) + 2 d^2 (t1.t2 - 1) = 0.

#include "orthodrive/network/fit_plan.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "roadquery/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Arc;
using roadquery::Line;
using roadquery::PlanElement;

// Tangents look this far to both sides: two node spacings against node noise, less where the line bends more within that
// than a circle does.
constexpr double stencils_m[] = {4.0, 2.0};
// A stretch counts as straight when it is this long and within half the tolerance of its chord: an arc as flat as that
// has a radius of 5 km and more (at 0.08 m).
constexpr double straight_min_length_m = 40.0;
constexpr double straight_run_in_m = 5.0;  // left to curves at both ends, so that neighbouring straights can join

double wrap_angle(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

double curvature_of(const PlanElement& e) {
  const Arc* arc = std::get_if<Arc>(&e.shape);
  return arc ? arc->curvature : 0.0;
}

Vec2 unit(double heading) { return {std::cos(heading), std::sin(heading)}; }

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

struct Foot {
  double ds = 0.0, distance = 0.0;
};

/// Nearest point of a line or arc of less than a full turn.
Foot project(const PlanElement& e, Vec2 p) {
  const Vec2 d = unit(e.hdg), r = p - Vec2{e.x, e.y};
  const double k = curvature_of(e);
  double ds = dot(r, d);
  if (k != 0.0) {
    const double radius = 1.0 / k;
    const Vec2 from_center = r - left_normal(d) * radius;
    // Angle turned since the start, measured around the centre in the sense of the arc, in (-pi, pi] about the middle.
    const double middle = 0.5 * k * e.length;
    const Vec2 a = left_normal(d) * -radius;
    const double angle = std::atan2(cross(a, from_center), dot(a, from_center));
    ds = (middle + wrap_angle(angle - middle)) / k;
  }
  ds = std::clamp(ds, 0.0, e.length);
  const roadquery::PlanPoint q = roadquery::evaluate(e, ds);
  return {ds, distance(p, {q.x, q.y})};
}

/// Points, their arc length, and what lies before the first and after the last one of a closed line.
class PointLine {
 public:
  PointLine(std::span<const Vec2> points, bool closed) : points_(points), closed_(closed), s_(points.size(), 0.0) {
    for (std::size_t i = 1; i < points.size(); ++i) s_[i] = s_[i - 1] + distance(points[i - 1], points[i]);
  }
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] Vec2 operator[](std::size_t i) const { return points_[i]; }
  [[nodiscard]] double s(std::size_t i) const { return s_[i]; }

  /// The first point at least `reach` away before (step -1) or after (+1) point i; the end of an open line at worst.
  [[nodiscard]] std::size_t neighbour(std::size_t i, int step, double reach) const {
    const std::size_t n = points_.size();
    double walked = 0.0;
    std::size_t at = i;
    for (std::size_t guard = 0; guard < n && walked < reach; ++guard) {
      if (step > 0 && at + 1 == n) {
        if (!closed_) break;
        at = 0;
      } else if (step < 0 && at == 0) {
        if (!closed_) break;
        at = n - 1;
      }
      const std::size_t to = step > 0 ? at + 1 : at - 1;
      walked += distance(points_[at], points_[to]);
      at = to;
    }
    return at;
  }

 private:
  std::span<const Vec2> points_;
  bool closed_;
  std::vector<double> s_;
};

/// Tangent at b of the circle through a, b, c: exact on circles for any spacing.
Vec2 circle_tangent(Vec2 a, Vec2 b, Vec2 c) {
  const Vec2 in = b - a, out = c - b;
  const double l1 = dot(in, in), l2 = dot(out, out);
  if (l1 <= 0.0 || l2 <= 0.0) return normalized(c - a);
  const Vec2 t = normalized(in * (1.0 / l1) + out * (1.0 / l2));
  return length(t) > 0.0 ? t : normalized(out);
}

Vec2 mirrored(Vec2 t, Vec2 chord) {
  const Vec2 c = normalized(chord);
  return normalized(c * (2.0 * dot(t, c)) - t);
}

double distance_to_circle(Vec2 a, Vec2 b, Vec2 c, Vec2 p) {
  const Vec2 u = b - a, v = c - a;
  const double area = 2.0 * cross(u, v);
  if (std::abs(area) < 1e-9) return std::abs(cross(normalized(v), p - a));
  const Vec2 center = a + Vec2{v.y * dot(u, u) - u.y * dot(v, v), u.x * dot(v, v) - v.x * dot(u, u)} * (1.0 / area);
  return std::abs(distance(center, p) - distance(center, a));
}

/// The points before and after i that its tangent is taken from (i itself at the ends of open lines).
struct Stencil {
  std::size_t before = 0, after = 0;
};

Stencil stencil_of(const PointLine& line, std::size_t i, double tolerance) {
  const auto on_circle = [&](Stencil s) {
    for (const int step : {-1, 1})
      for (std::size_t k = line.neighbour(i, step, 1e-9); k != (step < 0 ? s.before : s.after); k = line.neighbour(k, step, 1e-9))
        if (distance_to_circle(line[s.before], line[i], line[s.after], line[k]) > tolerance) return false;
    return true;
  };
  for (const double reach : stencils_m) {
    const Stencil s{line.neighbour(i, -1, reach), line.neighbour(i, 1, reach)};
    if (s.before == i || s.after == i || on_circle(s)) return s;
  }
  return {line.neighbour(i, -1, 1e-9), line.neighbour(i, 1, 1e-9)};
}

std::vector<Vec2> point_tangents(const PointLine& line, double tolerance) {
  const std::size_t n = line.size();
  std::vector<Vec2> t(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto [a, c] = stencil_of(line, i, tolerance);
    if (a != i && c != i) {
      t[i] = circle_tangent(line[a], line[i], line[c]);
    } else {  // an end of an open line: the circle through it and two points further in
      const int step = a == i ? 1 : -1;
      const std::size_t b = step > 0 ? c : a, far = line.neighbour(b, step, stencils_m[0]);
      const Vec2 chord = (line[b] - line[i]) * static_cast<double>(step);
      t[i] = far == b ? normalized(chord)
                      : mirrored(circle_tangent(line[i], line[b], line[far]) * static_cast<double>(step), chord);
    }
    if (!(length(t[i]) > 0.5)) t[i] = {1.0, 0.0};
  }
  return t;
}

double distance_to_chord(Vec2 a, Vec2 b, Vec2 p) {
  const Vec2 d = normalized(b - a);
  return std::abs(cross(d, p - a));
}

/// Last index of the longest straight stretch that starts at i (found by doubling, then halving).
std::size_t straight_reach(const PointLine& line, std::size_t i, double tolerance) {
  const auto straight = [&](std::size_t j) {
    for (std::size_t k = i + 1; k < j; ++k)
      if (distance_to_chord(line[i], line[j], line[k]) > tolerance) return false;
    return distance(line[i], line[j]) > 0.999 * (line.s(j) - line.s(i));
  };
  std::size_t good = i + 1, step = 1;
  while (good + step < line.size() && straight(good + step)) good += step, step *= 2;
  for (; step > 0; step /= 2)
    if (good + step < line.size() && straight(good + step)) good += step;
  return good;
}

struct Straight {
  std::size_t first = 0, last = 0;
};

std::vector<Straight> find_straights(const PointLine& line, const FitPlanOptions& options) {
  std::vector<Straight> found;
  const std::size_t end = line.size() - 1;
  for (std::size_t i = 0; i < end;) {
    const std::size_t j = straight_reach(line, i, 0.5 * options.tolerance_m);
    if (line.s(j) - line.s(i) < straight_min_length_m) {
      ++i;
      continue;
    }
    std::size_t first = i, last = j;
    while ((i > 0 || options.closed) && line.s(first) - line.s(i) < straight_run_in_m) ++first;
    while ((j < end || options.closed) && line.s(j) - line.s(last) < straight_run_in_m) --last;
    found.push_back({first, last});
    i = j;
  }
  return found;
}

/// Biarc over points i..j if it stays within the tolerance of those between.
bool biarc_fits(const PointLine& line, std::span<const Vec2> tangent, std::size_t i, std::size_t j, double tolerance,
                std::vector<PlanElement>& elements) {
  elements = biarc({line[i], tangent[i]}, {line[j], tangent[j]});
  if (j == i + 1) return true;
  // A biarc may reach all points and still swing wide between them: then it is much longer than they are.
  if (plan_length(elements) > 1.02 * (line.s(j) - line.s(i)) + 0.05) return false;
  for (std::size_t k = i + 1; k < j; ++k) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const PlanElement& e : elements) nearest = std::min(nearest, project(e, line[k]).distance);
    if (nearest > tolerance) return false;
  }
  return true;
}

std::size_t biarc_reach(const PointLine& line, std::span<const Vec2> tangent, std::size_t i, std::size_t limit,
                        double tolerance) {
  std::vector<PlanElement> scratch;
  std::size_t good = i + 1, step = 1;
  while (good + step <= limit && biarc_fits(line, tangent, i, good + step, tolerance, scratch)) good += step, step *= 2;
  for (; step > 0; step /= 2)
    if (good + step <= limit && biarc_fits(line, tangent, i, good + step, tolerance, scratch)) good += step;
  return good;
}

/// Neighbouring arcs of one circle become one.
void append(std::vector<PlanElement>& plan, std::span<const PlanElement> elements, Vec2 origin) {
  for (PlanElement e : elements) {
    if (!plan.empty()) {
      PlanElement& last = plan.back();
      const double k0 = curvature_of(last), k1 = curvature_of(e), l = last.length + e.length;
      if (std::abs(k1 - k0) * l < 1e-8 && std::abs(k0 * l) < std::numbers::pi) {
        last.length = l;
        continue;
      }
    }
    e.x += origin.x, e.y += origin.y;
    e.s = plan.empty() ? 0.0 : plan.back().s + plan.back().length;
    plan.push_back(e);
  }
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

double plan_length(std::span<const PlanElement> plan) { return plan.empty() ? 0.0 : plan.back().s + plan.back().length; }

Pose pose_at(std::span<const PlanElement> plan, double s) {
  assert(!plan.empty());
  const auto next = std::upper_bound(plan.begin() + 1, plan.end(), s, [](double a, const PlanElement& e) { return a < e.s; });
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
    const roadquery::PlanPoint q = roadquery::evaluate(e, a - e.s);
    result.push_back({.s = result.empty() ? 0.0 : plan_length(result), .x = q.x, .y = q.y, .hdg = wrap_angle(q.hdg),
                      .length = b - a, .shape = e.shape});
  }
  return result;
}

std::vector<PlanElement> reverse_plan(std::span<const PlanElement> plan) {
  std::vector<PlanElement> result;
  for (auto it = plan.rbegin(); it != plan.rend(); ++it) {
    const roadquery::PlanPoint q = roadquery::evaluate(*it, it->length);
    PlanElement e{.s = plan_length(result), .x = q.x, .y = q.y, .hdg = wrap_angle(q.hdg + std::numbers::pi),
                  .length = it->length, .shape = it->shape};
    if (Arc* arc = std::get_if<Arc>(&e.shape)) arc->curvature = -arc->curvature;
    result.push_back(e);
  }
  return result;
}

PlanFit fit_plan(std::span<const Vec2> points, const FitPlanOptions& options) {
  assert(points.size() >= 2);
  // Differences of UTM coordinates lose digits: work relative to the first point.
  const Vec2 origin = points.front();
  std::vector<Vec2> local(points.begin(), points.end());
  for (Vec2& p : local) p = p - origin;
  const PointLine line(local, options.closed);
  std::vector<Vec2> tangent = point_tangents(line, 0.5 * options.tolerance_m);
  if (options.closed) tangent.back() = tangent.front();

  const std::vector<Straight> straights = find_straights(line, options);
  for (const Straight& straight : straights)
    tangent[straight.first] = tangent[straight.last] = normalized(local[straight.last] - local[straight.first]);

  PlanFit fit;
  fit.point_s.assign(points.size(), 0.0);
  const auto add = [&](std::size_t i, std::size_t j) {
    const std::vector<PlanElement> elements = biarc({local[i], tangent[i]}, {local[j], tangent[j]});
    const double start = plan_length(fit.elements);
    append(fit.elements, elements, origin);
    for (std::size_t k = i + 1; k < j; ++k) {
      Foot best{0.0, std::numeric_limits<double>::infinity()};
      for (const PlanElement& e : elements) {
        const Foot foot = project(e, local[k]);
        if (foot.distance < best.distance) best = {e.s + foot.ds, foot.distance};
      }
      fit.max_deviation_m = std::max(fit.max_deviation_m, best.distance);
      fit.point_s[k] = std::max(fit.point_s[k - 1], start + best.ds);
    }
    fit.point_s[j] = start + plan_length(elements);
  };
  std::size_t at = 0;
  const auto curve_to = [&](std::size_t limit) {
    while (at < limit) {
      const std::size_t to = biarc_reach(line, tangent, at, limit, options.tolerance_m);
      add(at, to);
      at = to;
    }
  };
  for (const Straight& straight : straights) {
    curve_to(straight.first);
    add(straight.first, straight.last);
    at = straight.last;
  }
  curve_to(line.size() - 1);
  return fit;
}

}  // namespace orthodrive::network
