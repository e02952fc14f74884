// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/refit_profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/math/cholesky.hpp"
#include "orthodrive/math/cubic_spline.hpp"
#include "orthodrive/network/junctions/road_cover.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/surface/surface_gradient.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Cubic;
using roadquery::Road;

constexpr double least_knot_m = 2.5, profile_step_m = 0.5;
constexpr double least_rough_m = 1.5, rough = 4.0;  // pieces of which the tolerance is missed by that factor
constexpr double tolerance_m = 0.005;               // more pieces until the lanes lie so near to what the surface wants
constexpr double knot_unit_m = 0.01, height_unit_m = 1e-4,
                 banking_unit = 1e-5;  // between the ends: numbers of few digits
constexpr double share = 0.5;          // of the heights in that, the rest is the banking's
constexpr int across = 5;              // places of a cross section
constexpr double rate_step_m = 0.1;
constexpr double least_width_m = 0.5;

/// Values along the road and their slopes by s.
struct ProfileSection {
  double z = 0.0, bank = 0.0;
};

roadquery::Edges edges_at(const Road& road, double s) { return carriageway_edges(road, s); }

/// The straight line of least squares through what value(x, y, t) says at places across the lanes.
struct LineAcross {
  double at_reference = 0.0, slope = 0.0;
};
template <typename Value>
LineAcross line_across(const Road& road, double s, const Value& value) {
  const roadquery::PlanPoint p = roadquery::reference_point(road, s);
  const roadquery::Edges edges = edges_at(road, s);
  const double middle = 0.5 * (edges.left_t + edges.right_t);
  const double half = 0.5 * std::max(edges.left_t - edges.right_t, least_width_m);
  double sum = 0.0, moment = 0.0, square = 0.0;
  for (int i = 0; i < across; ++i) {
    const double off = half * (2.0 * i / (across - 1) - 1.0), t = middle + off;
    const double v = value(p.x - t * std::sin(p.hdg), p.y + t * std::cos(p.hdg), t);
    sum += v, moment += off * v, square += off * off;
  }
  const double slope = moment / square;
  return {sum / across - middle * slope, slope};
}

/// The line through the surface less the road's shape. Over a place of the plane a cross section that is pitched by the
/// slope lies higher by 1 / cos(pitch).
ProfileSection section_at(const Road& road, const roadquery::JunctionSurface& surface, double s) {
  const roadquery::PlanPoint p = roadquery::reference_point(road, s);
  const roadquery::JunctionHeight middle = roadquery::evaluate(surface, p.x, p.y);
  const double slope = middle.dz_dx * std::cos(p.hdg) + middle.dz_dy * std::sin(p.hdg);
  const double higher = std::sqrt(1.0 + slope * slope);
  const LineAcross line = line_across(road, s, [&](double x, double y, double t) {
    return roadquery::evaluate(surface, x, y).z - higher * roadquery::shape(road, s, t).h;
  });
  return {line.at_reference, std::atan(line.slope / higher)};
}

double rounded_to(double v, double unit) { return std::round(v / unit) * unit; }

/// A spline of values in multiples of `unit`.
std::vector<Cubic> cubics_of(const CubicSpline& spline, double unit) {
  std::vector<Cubic> cubics;
  for (std::size_t i = 0; i + 1 < spline.knots.size(); ++i) {
    const double s = spline.knots[i], length = spline.knots[i + 1] - s;
    cubics.push_back({s, spline.values[i] / unit, spline.slope(s) / unit, 0.5 * spline.second[i] / unit,
                      (spline.second[i + 1] - spline.second[i]) / (6.0 * length * unit)});
  }
  return cubics;
}

/// The sections that the profile should have, at even places of the road.
struct Wanted {
  double step_m = 0.0;
  std::vector<ProfileSection> sections;
  double start_rate = 0.0, end_rate = 0.0;  ///< of the banking
  double half_m = 0.0;                      ///< half the width of the lanes, at most

  [[nodiscard]] double s(std::size_t i) const { return step_m * static_cast<double>(i); }
};

Wanted wanted_of(const Road& road, const roadquery::JunctionSurface& surface, const ProfileEnds& ends) {
  Wanted wanted;
  const auto count = static_cast<std::size_t>(std::max(2.0, std::ceil(road.length / profile_step_m)));
  wanted.step_m = road.length / static_cast<double>(count);
  for (std::size_t i = 0; i <= count; ++i) {
    const double s = i == count ? road.length : wanted.s(i);
    wanted.sections.push_back(i == 0       ? ProfileSection{ends.start.z, ends.start.banking}
                              : i == count ? ProfileSection{ends.end.z, ends.end.banking}
                                           : section_at(road, surface, s));
    const roadquery::Edges edges = edges_at(road, s);
    wanted.half_m = std::max({wanted.half_m, std::abs(edges.left_t), std::abs(edges.right_t)});
  }
  // A road that begins to turn at once turns its banking at once, too, however little the arm's changes.
  const auto rate = [&](double s, double step) {
    return (section_at(road, surface, s + step).bank - section_at(road, surface, s).bank) / step;
  };
  const double step = std::min(rate_step_m, 0.5 * road.length);
  wanted.start_rate = rate(0.0, step), wanted.end_rate = rate(road.length, -step);
  return wanted;
}

/// What a spline follows: the values at all places of the wanted sections, and the slopes at the ends.
struct Course {
  std::vector<double> values;
  double step_m = 0.0, first_slope = 0.0, last_slope = 0.0, tolerance = 0.0;
  double unit = 0.0;  ///< a spline has multiples of it between the ends

  [[nodiscard]] double s(std::size_t i) const { return step_m * static_cast<double>(i); }
  /// Where a spline has a knot that stands for a place.
  [[nodiscard]] double knot_s(std::size_t i) const {
    return i == 0 || i + 1 == values.size() ? s(i) : rounded_to(s(i), knot_unit_m);
  }
};

/// Places of a course, the first and the last among them.
using Knots = std::vector<std::size_t>;

/// Values of a spline at all places of its course.
std::vector<double> sampled(const CubicSpline& spline, const Course& course) {
  std::vector<double> values;
  values.reserve(course.values.size());
  for (std::size_t i = 0; i < course.values.size(); ++i) values.push_back(spline.at(course.s(i)));
  return values;
}

/// The clamped spline of least squares that has the first and the last value.
CubicSpline least_squares_spline(const Course& course, const Knots& knots) {
  const std::size_t free = knots.size() - 2;
  std::vector<double> s, values(knots.size(), 0.0);
  for (const std::size_t i : knots) s.push_back(course.knot_s(i));
  values.front() = course.values.front(), values.back() = course.values.back();
  const std::vector<double> rest = sampled(clamped_spline(s, values, course.first_slope, course.last_slope), course);
  std::vector<std::vector<double>> shares;  // of each free value in all places
  for (std::size_t k = 0; k < free; ++k) {
    std::vector<double> unit(knots.size(), 0.0);
    unit[k + 1] = 1.0;
    shares.push_back(sampled(clamped_spline(s, std::move(unit), 0.0, 0.0), course));
  }
  std::vector<double> normal(free * free), right(free, 0.0);
  for (std::size_t k = 0; k < free; ++k)
    for (std::size_t i = 0; i < rest.size(); ++i) {
      right[k] += shares[k][i] * (course.values[i] - rest[i]);
      for (std::size_t m = 0; m <= k; ++m) normal[k * free + m] += shares[k][i] * shares[m][i];
    }
  if (free > 0) {
    const SymmetricMatrix matrix = SymmetricMatrix::dense(normal.data(), free, free);
    if (factorize(matrix))
      solve_factored(matrix, right);
    else
      for (std::size_t k = 0; k < free; ++k) right[k] = course.values[knots[k + 1]];
  }
  for (std::size_t k = 0; k < free; ++k) values[k + 1] = rounded_to(right[k], course.unit);
  return clamped_spline(std::move(s), std::move(values), course.first_slope, course.last_slope);
}

/// Distances of the values from the spline of these knots.
std::vector<double> distances(const Course& course, const Knots& knots) {
  std::vector<double> off = sampled(least_squares_spline(course, knots), course);
  for (std::size_t i = 0; i < off.size(); ++i) off[i] = std::abs(off[i] - course.values[i]);
  return off;
}

/// Pieces are halved until all values lie within the tolerance or pieces are short.
Knots halved(const Course& course) {
  Knots knots{0, course.values.size() - 1};
  for (;;) {
    const std::vector<double> off = distances(course, knots);
    Knots finer{0};
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
      const std::size_t from = knots[k], to = knots[k + 1];
      const double worst = *std::max_element(off.begin() + static_cast<std::ptrdiff_t>(from),
                                             off.begin() + static_cast<std::ptrdiff_t>(to) + 1);
      const double least_m = worst > rough * course.tolerance ? least_rough_m : least_knot_m;
      if (worst > course.tolerance && course.s(to - from) >= 2.0 * least_m) finer.push_back((from + to) / 2);
      finer.push_back(to);
    }
    if (finer.size() == knots.size()) return knots;
    knots = std::move(finer);
  }
}

/// Heights along the road and the heights of the edges of the lanes over it.
struct Profile {
  std::array<Course, 2> courses;
  std::array<Knots, 2> knots;

  [[nodiscard]] std::array<std::vector<double>, 2> off() const {
    return {distances(courses[0], knots[0]), distances(courses[1], knots[1])};
  }
};

/// Of a candidate that has `here` instead of what the other half of `off` goes with: the worst share of what is
/// allowed.
double worst_share(const std::vector<double>& here, const std::vector<double>& other,
                   const std::vector<double>& allowed) {
  double worst = 0.0;
  for (std::size_t i = 0; i < here.size(); ++i) worst = std::max(worst, (here[i] + other[i]) / allowed[i]);
  return worst;
}

/// Takes knots out, the least needed first, as long as the lanes lie everywhere within the tolerance or as near as
/// before.
void thin(Profile& profile) {
  auto off = profile.off();
  std::vector<double> allowed;
  allowed.reserve(off[0].size());
  for (std::size_t i = 0; i < off[0].size(); ++i) allowed.push_back(std::max(tolerance_m, off[0][i] + off[1][i]));
  for (;;) {
    double least = 1.0 + 1e-9;
    std::size_t which = 0;
    Knots fewer;
    for (const std::size_t p : {0U, 1U})
      for (std::size_t k = 1; k + 1 < profile.knots[p].size(); ++k) {
        Knots without = profile.knots[p];
        without.erase(without.begin() + static_cast<std::ptrdiff_t>(k));
        const double worst = worst_share(distances(profile.courses[p], without), off[1 - p], allowed);
        if (worst < least) least = worst, which = p, fewer = std::move(without);
      }
    if (fewer.empty()) return;
    profile.knots[which] = std::move(fewer);
    off[which] = distances(profile.courses[which], profile.knots[which]);
  }
}

}  // namespace

double distance_from_surface_m(const Road& road, const roadquery::JunctionSurface& surface) {
  double largest = 0.0;
  for (double s = 0.0;; s = std::min(s + profile_step_m, road.length)) {
    const roadquery::Edges edges = edges_at(road, s);
    for (int i = 0; i < across; ++i) {
      const double t = edges.right_t + (edges.left_t - edges.right_t) * i / (across - 1);
      const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
      largest = std::max(largest, std::abs(p.z - roadquery::evaluate(surface, p.x, p.y).z));
    }
    if (s >= road.length) break;
  }
  return largest;
}

double distance_across_m(const Road& road, double s, double sign, const roadquery::Edges& lanes) {
  const roadquery::SurfacePoint a = roadquery::surface_point(road, s, sign * lanes.left_t);
  const roadquery::SurfacePoint b = roadquery::surface_point(road, s, sign * lanes.right_t);
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

ProfileEnd end_beside(const Road& other, bool at_end, double sign, double t, const roadquery::Edges& lanes) {
  const double s = at_end ? other.length : 0.0;
  const auto z = [&](double at_t) { return roadquery::surface_height(other, s, sign * at_t); };
  const roadquery::SurfacePoint p = roadquery::surface_point(other, s, sign * t);
  const double gradient = roadquery::gradient_towards(p, roadquery::reference_point(other, s).hdg);
  const double rise = z(lanes.left_t) - z(lanes.right_t);
  // Of the edges' distance the pitched cross section rises by the sine of its roll times the cosine of its pitch.
  const double roll = rise / distance_across_m(other, s, sign, lanes) * std::sqrt(1.0 + gradient * gradient);
  const double share = (t - lanes.right_t) / (lanes.left_t - lanes.right_t);
  return {z(lanes.right_t) + share * rise, sign * gradient, std::asin(std::clamp(roll, -1.0, 1.0))};
}

ProfileEnd end_on(const Road& road, const roadquery::JunctionSurface& surface, bool at_end) {
  const double s = at_end ? road.length : 0.0;
  const roadquery::PlanPoint p = roadquery::reference_point(road, s);
  const LineAcross gradient = line_across(road, s, [&](double x, double y, double t) {
    const roadquery::JunctionHeight h = roadquery::evaluate(surface, x, y);
    return (h.dz_dx * std::cos(p.hdg) + h.dz_dy * std::sin(p.hdg)) * (1.0 - p.curvature * t);
  });
  const ProfileSection section = section_at(road, surface, s);
  return {section.z, gradient.at_reference, section.bank};
}

Road refitted(const Road& road, const roadquery::JunctionSurface& surface, const ProfileEnds& ends) {
  constexpr double shortest_m = 0.1;
  if (road.length < shortest_m) return road;
  const Wanted wanted = wanted_of(road, surface, ends);
  Course z{{}, wanted.step_m, ends.start.gradient, ends.end.gradient, share * tolerance_m, height_unit_m};
  Course edge{{},
              wanted.step_m,
              wanted.start_rate * wanted.half_m,
              wanted.end_rate * wanted.half_m,
              (1.0 - share) * tolerance_m,
              banking_unit * wanted.half_m};
  for (const ProfileSection& section : wanted.sections)
    z.values.push_back(section.z), edge.values.push_back(section.bank * wanted.half_m);
  Profile profile{{std::move(z), std::move(edge)}, {}};
  for (const std::size_t p : {0U, 1U}) profile.knots[p] = halved(profile.courses[p]);
  thin(profile);
  Road fitted = road;
  fitted.elevation = cubics_of(least_squares_spline(profile.courses[0], profile.knots[0]), 1.0);
  fitted.superelevation = cubics_of(least_squares_spline(profile.courses[1], profile.knots[1]), wanted.half_m);
  const auto level = [](const Cubic& c) { return c.a == 0.0 && c.b == 0.0 && c.c == 0.0 && c.d == 0.0; };
  if (std::all_of(fitted.superelevation.begin(), fitted.superelevation.end(), level)) fitted.superelevation.clear();
  return fitted;
}

}  // namespace orthodrive::network
