// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/crg/sample_crg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/angle.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using roadquery::PlanPoint;
using roadquery::Road;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
constexpr double max_fold = 0.05;  // of 1 - curvature * left: nearer to the centre of curvature heights mean nothing

/// What a file gives back for a value: decimals of LRFI and LDFI are those of columns 10 and 20 wide (opencrg_io.hpp).
double rounded(double value, CrgFormat format) {
  switch (format) {
    case CrgFormat::lrfi:
      return std::round(value * 1e7) * 1e-7;
    case CrgFormat::krbi:
      return static_cast<float>(value);
    case CrgFormat::ldfi:
    case CrgFormat::kdbi:
      break;
  }
  return value;
}

/// Reference line, straight on beyond the road's end.
PlanPoint line_point(const Road& road, double s) {
  PlanPoint p = roadquery::reference_point(road, s);
  const double beyond = s - std::clamp(s, 0.0, road.length);
  p.x += beyond * std::cos(p.hdg), p.y += beyond * std::sin(p.hdg);
  return p;
}

/// Longer than road.length where a paramPoly3's parameter is not the arc length.
double arc_length(const Road& road, double step_m) {
  const auto count = static_cast<std::size_t>(std::ceil(road.length / step_m));
  double length_m = 0.0;
  Vec2 before;
  for (std::size_t i = 0; i <= count; ++i) {
    const PlanPoint q = line_point(road, road.length * static_cast<double>(i) / static_cast<double>(count));
    if (i > 0) length_m += distance(before, {q.x, q.y});
    before = {q.x, q.y};
  }
  return length_m;
}

/// s after `from_s` of the point a chord away from p. Newton; the chord is short against the radius.
double chord_end(const Road& road, Vec2 p, double from_s, double chord_m) {
  double s = from_s + chord_m;
  for (int i = 0; i < 8; ++i) {
    const PlanPoint q = line_point(road, s);
    const Vec2 d = Vec2{q.x, q.y} - p;
    const double along = dot(d, {std::cos(q.hdg), std::sin(q.hdg)}) * q.speed;
    const double step = (chord_m * chord_m - dot(d, d)) / (2.0 * std::max(along, 0.1 * chord_m));
    s += step;
    if (std::abs(step) < 1e-11) break;
  }
  return s;
}

struct CrgWalk {
  std::vector<double> s, phi;  ///< a row; phi[0] repeats phi[1]
};

CrgWalk walk(const Road& road, std::size_t steps, double chord_m, CrgFormat format) {
  CrgWalk result{{0.0}, {0.0}};
  const PlanPoint start = line_point(road, 0.0);
  Vec2 p{start.x, start.y};
  for (std::size_t i = 1; i <= steps; ++i) {
    const double s = chord_end(road, p, result.s.back(), chord_m);
    const PlanPoint q = line_point(road, s);
    const double phi = rounded(std::atan2(q.y - p.y, q.x - p.x), format);
    p = p + Vec2{std::cos(phi), std::sin(phi)} * chord_m;
    result.s.push_back(s), result.phi.push_back(phi);
  }
  result.phi[0] = result.phi[1];
  return result;
}

/// The chord that `steps` of end at the road's end: secant method on where they end.
double fitting_chord(const Road& road, double length_m, std::size_t steps, CrgFormat format) {
  const auto miss = [&](double chord_m) { return walk(road, steps, chord_m, format).s.back() - road.length; };
  double a = length_m / static_cast<double>(steps), b = a * (1.0 - 1e-5);
  double miss_a = miss(a), miss_b = miss(b);
  for (int i = 0; i < 6 && std::abs(miss_a) > 1e-8 && miss_a != miss_b; ++i) {
    const double next = a - miss_a * (b - a) / (miss_b - miss_a);
    b = a, miss_b = miss_a;
    a = next, miss_a = miss(a);
  }
  return a;
}

struct LineFoot {
  double s = 0.0, left_m = 0.0;
  bool folded = false;
};

/// Foot on the reference line, from s near it.
LineFoot foot_on_line(const Road& road, Vec2 xy, double s) {
  LineFoot foot{s, 0.0, false};
  for (int i = 0; i < 10; ++i) {
    const PlanPoint q = line_point(road, foot.s);
    const Vec2 d = xy - Vec2{q.x, q.y}, tangent{std::cos(q.hdg), std::sin(q.hdg)};
    foot.left_m = cross(tangent, d);
    const bool outside = foot.s < 0.0 || foot.s > road.length;
    const double stretch = outside ? 1.0 : 1.0 - q.curvature * foot.left_m;
    if (stretch < max_fold) return {s, 0.0, true};
    const double step = dot(d, tangent) / (stretch * q.speed);
    foot.s += step;
    if (std::abs(step) < 1e-10) break;
  }
  return foot;
}

/// Height of the surface, on by the road's gradient beyond its ends.
double height_at(const Road& road, const LineFoot& foot, const SampleCrgOptions& options) {
  const PlanPoint line = line_point(road, foot.s);
  const double x = line.x - foot.left_m * std::sin(line.hdg), y = line.y + foot.left_m * std::cos(line.hdg);
  const roadquery::RoadPosition at = roadquery::position_over(road, x, y, foot.s);
  const double z = roadquery::surface_height(road, at.s, at.t) + roadquery::gradient(road, at.s) * at.beyond_m;
  return options.relief_m ? z + options.relief_m(at.s, at.t) : z;
}

/// Columns over the widest part of the road.
std::vector<double> columns_of(const Road& road, const std::vector<roadquery::Edges>& edges, double step_m) {
  double right = 0.0, left = 0.0;
  for (const roadquery::Edges& e : edges) right = std::min(right, e.right_t), left = std::max(left, e.left_t);
  const double first = std::floor(right / step_m - 1e-6), last = std::ceil(left / step_m + 1e-6);
  std::vector<double> columns;
  for (double k = first; k <= last; k += 1.0) columns.push_back(k * step_m);
  for (const roadquery::ShapeCubic& shape : road.shape)
    if (shape.t > columns.front() && shape.t < columns.back()) columns.push_back(shape.t);
  std::sort(columns.begin(), columns.end());
  const double same = 0.01 * step_m;
  columns.erase(std::unique(columns.begin(), columns.end(), [&](double a, double b) { return b - a < same; }),
                columns.end());
  return columns;
}

CrgSurface sample_at_step(const Road& road, const SampleCrgOptions& options) {
  const double length_m = arc_length(road, options.u_step_m);
  const auto steps = static_cast<std::size_t>(std::max(1.0, std::ceil(length_m / options.u_step_m - 1e-9)));
  CrgSurface surface;
  surface.u_increment_m = fitting_chord(road, length_m, steps, options.format);
  CrgWalk line = walk(road, steps, surface.u_increment_m, options.format);
  surface.phi_rad = std::move(line.phi);
  const std::size_t rows = steps + 1;

  std::vector<roadquery::Edges> edges;
  double z = height_at(road, {0.0, 0.0, false}, {});
  const double z0 = z;
  surface.slope.push_back(0.0);
  for (std::size_t i = 0; i < rows; ++i) {
    const double s = std::clamp(line.s[i], 0.0, road.length);
    edges.push_back(roadquery::road_edges(road, s));
    const double slope = roadquery::gradient(road, s);  // banking is a slope in plan: the cross section is pitched
    const double across = std::tan(roadquery::superelevation(road, s)) * std::sqrt(1.0 + slope * slope);
    surface.banking.push_back(rounded(across, options.format));
    if (i == 0) continue;
    const double rise = height_at(road, {line.s[i], 0.0, false}, {}) - z;
    surface.slope.push_back(rounded(rise / surface.u_increment_m, options.format));
    z += surface.slope.back() * surface.u_increment_m;
  }
  surface.slope[0] = surface.slope[1];
  const PlanPoint start = line_point(road, 0.0);
  integrate_reference_line(surface, start.x, start.y, z0);

  surface.v_m = columns_of(road, edges, options.v_step_m);
  surface.grid_m.assign(rows * surface.columns(), missing);
  for (std::size_t i = 0; i < rows; ++i) {
    double right = edges[i].right_t, left = edges[i].left_t;  // of the rows about this one: cells need all four corners
    for (const std::size_t k : {i > 0 ? i - 1 : i, std::min(i + 1, rows - 1)})
      right = std::min(right, edges[k].right_t), left = std::max(left, edges[k].left_t);
    const double u = surface.u_start_m + surface.u_increment_m * static_cast<double>(i);
    const Vec2 on_line = crg_xy(surface, {u, 0.0}), across = crg_xy(surface, {u, 1.0}) - on_line;  // linear in v
    for (std::size_t j = 0; j < surface.columns(); ++j) {
      const double v = surface.v_m[j];
      if (v < right - options.v_step_m || v > left + options.v_step_m) continue;
      const LineFoot foot = foot_on_line(road, on_line + across * v, line.s[i]);
      if (foot.folded) continue;
      surface.grid_m[i * surface.columns() + j] =
          height_at(road, foot, options) - (surface.z_m[i] + surface.banking[i] * v);
    }
  }
  return surface;
}

/// Of the middles of the cells on the carriageway, where bilinear interpolation is worst.
double worst_error_m(const Road& road, const CrgSurface& surface) {
  double worst_m = 0.0;
  for (std::size_t i = 0; i + 1 < surface.rows(); ++i) {
    const double u = surface.u_start_m + surface.u_increment_m * (static_cast<double>(i) + 0.5);
    const roadquery::Edges edges = roadquery::road_edges(road, std::clamp(u, 0.0, road.length));
    for (std::size_t j = 0; j + 1 < surface.columns(); ++j) {
      const double v = 0.5 * (surface.v_m[j] + surface.v_m[j + 1]);
      if (v < edges.right_t || v > edges.left_t) continue;
      const double z = crg_height(surface, {u, v});
      const LineFoot foot = foot_on_line(road, crg_xy(surface, {u, v}), u);
      if (!std::isnan(z) && !foot.folded) worst_m = std::max(worst_m, std::abs(z - height_at(road, foot, {})));
    }
  }
  return worst_m;
}

}  // namespace

CrgSurface sample_crg(const roadquery::Road& road, const SampleCrgOptions& options) {
  constexpr double smallest_share = 1.0 / 16.0;  // of the step
  if (!(road.length > 1e-3) || road.plan.empty() || road.sections.empty())
    throw Error(fmt::format("road {} has no surface to sample", road.id));
  SampleCrgOptions plain = options;
  plain.relief_m = {};
  CrgSurface surface = sample_at_step(road, plain);
  while (options.tolerance_m > 0.0 && plain.u_step_m > smallest_share * options.u_step_m * 1.001 &&
         worst_error_m(road, surface) > options.tolerance_m) {
    plain.u_step_m *= 0.5;
    surface = sample_at_step(road, plain);
  }
  if (!options.relief_m) return surface;
  plain.relief_m = options.relief_m;
  return sample_at_step(road, plain);
}

roadquery::SurfaceCrg crg_reference(const roadquery::Road& road, const CrgSurface& surface, const std::string& file) {
  roadquery::SurfaceCrg reference;
  reference.file = file;
  reference.s_end = road.length;
  reference.h_offset = wrapped_angle(surface.phi_rad[1] - roadquery::reference_point(road, 0.0).hdg);
  return reference;
}

}  // namespace orthodrive
