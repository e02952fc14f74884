#include "orthodrive/network/refit_profile.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/math/cubic_spline.hpp"
#include "orthodrive/network/road_cover.hpp"
#include "roadquery/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Cubic;
using roadquery::Road;

constexpr double least_knot_m = 2.5, step_m = 0.5;
constexpr double least_rough_m = 1.5, rough = 4.0;  // pieces of which the tolerance is missed by that factor
constexpr double tolerance_m = 0.005;               // more pieces until the lanes lie so near to what the surface wants
constexpr double share = 0.5;                       // of the heights in that, the rest is the banking's
constexpr int across = 5;                           // places of a cross section
constexpr double rate_step_m = 0.1;
constexpr double least_width_m = 0.5;

/// Values along the road and their slopes by s.
struct Section {
  double z = 0.0, bank = 0.0;
};

roadquery::Edges lanes_at(const Road& road, double s) { return carriageway_edges(road, s); }

/// The straight line of least squares through the surface less the road's shape, over the lanes.
Section section_at(const Road& road, const roadquery::JunctionSurface& surface, double s) {
  const roadquery::PlanPoint p = roadquery::reference_point(road, s);
  const roadquery::Edges edges = lanes_at(road, s);
  const double middle = 0.5 * (edges.left_t + edges.right_t);
  const double half = 0.5 * std::max(edges.left_t - edges.right_t, least_width_m);
  double sum = 0.0, moment = 0.0, square = 0.0;
  for (int i = 0; i < across; ++i) {
    const double off = half * (2.0 * i / (across - 1) - 1.0), t = middle + off;
    const double z = roadquery::evaluate(surface, p.x - t * std::sin(p.hdg), p.y + t * std::cos(p.hdg)).z -
                     roadquery::shape(road, s, t).h;
    sum += z, moment += off * z, square += off * off;
  }
  const double slope = moment / square;
  return {sum / across - middle * slope, std::atan(slope)};
}

std::vector<Cubic> cubics_of(const CubicSpline& spline) {
  std::vector<Cubic> cubics;
  for (std::size_t i = 0; i + 1 < spline.knots.size(); ++i) {
    const double s = spline.knots[i], length = spline.knots[i + 1] - s;
    cubics.push_back({s, spline.values[i], spline.slope(s), 0.5 * spline.second[i],
                      (spline.second[i + 1] - spline.second[i]) / (6.0 * length)});
  }
  return cubics;
}

/// The sections that the profile should have, at even places of the road.
struct Wanted {
  double step_m = 0.0;
  std::vector<Section> sections;
  double start_rate = 0.0, end_rate = 0.0;  ///< of the banking
  double half_m = 0.0;                      ///< half the width of the lanes, at most

  [[nodiscard]] double s(std::size_t i) const { return step_m * static_cast<double>(i); }
};

Wanted wanted_of(const Road& road, const roadquery::JunctionSurface& surface, const ProfileEnds& ends) {
  Wanted wanted;
  const auto count = static_cast<std::size_t>(std::max(2.0, std::ceil(road.length / step_m)));
  wanted.step_m = road.length / static_cast<double>(count);
  for (std::size_t i = 0; i <= count; ++i) {
    const double s = i == count ? road.length : wanted.s(i);
    wanted.sections.push_back(i == 0       ? Section{ends.start.z, ends.start.banking}
                              : i == count ? Section{ends.end.z, ends.end.banking}
                                           : section_at(road, surface, s));
    const roadquery::Edges edges = lanes_at(road, s);
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

/// What a spline goes through: the values at all places of the wanted sections, and the slopes at the ends.
struct Course {
  std::vector<double> values;
  double first_slope = 0.0, last_slope = 0.0, tolerance = 0.0;
};

/// A spline of few pieces through the first value, the last one and some between: pieces are split until all values lie
/// within the tolerance or pieces are short.
CubicSpline through(const Course& course, double step_m) {
  std::vector<std::size_t> knots{0, course.values.size() - 1};
  for (;;) {
    std::vector<double> s, values;
    for (const std::size_t i : knots) s.push_back(step_m * static_cast<double>(i)), values.push_back(course.values[i]);
    CubicSpline spline = clamped_spline(s, std::move(values), course.first_slope, course.last_slope);
    std::vector<std::size_t> finer{0};
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
      double off = 0.0;
      for (std::size_t i = knots[k] + 1; i < knots[k + 1]; ++i)
        off = std::max(off, std::abs(spline.at(step_m * static_cast<double>(i)) - course.values[i]));
      const double length_m = step_m * static_cast<double>(knots[k + 1] - knots[k]);
      const double least_m = off > rough * course.tolerance ? least_rough_m : least_knot_m;
      if (off > course.tolerance && length_m >= 2.0 * least_m) finer.push_back((knots[k] + knots[k + 1]) / 2);
      finer.push_back(knots[k + 1]);
    }
    if (finer.size() == knots.size()) return spline;
    knots = std::move(finer);
  }
}

}  // namespace

double distance_from_surface_m(const Road& road, const roadquery::JunctionSurface& surface) {
  double largest = 0.0;
  for (double s = 0.0;; s = std::min(s + step_m, road.length)) {
    const roadquery::Edges edges = lanes_at(road, s);
    for (int i = 0; i < across; ++i) {
      const double t = edges.right_t + (edges.left_t - edges.right_t) * i / (across - 1);
      const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
      largest = std::max(largest, std::abs(p.z - roadquery::evaluate(surface, p.x, p.y).z));
    }
    if (s >= road.length) break;
  }
  return largest;
}

ProfileEnd end_beside(const Road& other, bool at_end, double sign, double t, const roadquery::Edges& lanes) {
  const double s = at_end ? other.length : 0.0;
  const auto z = [&](double at_t) { return roadquery::surface_height(other, s, sign * at_t); };
  const roadquery::SurfacePoint p = roadquery::surface_point(other, s, sign * t);
  const double hdg = roadquery::reference_point(other, s).hdg;
  const double gradient = -(std::cos(hdg) * p.normal[0] + std::sin(hdg) * p.normal[1]) / p.normal[2];
  const double slope = (z(lanes.left_t) - z(lanes.right_t)) / (lanes.left_t - lanes.right_t);
  return {z(t), sign * gradient, std::asin(slope)};
}

ProfileEnd end_on(const Road& road, const roadquery::JunctionSurface& surface, bool at_end) {
  const double s = at_end ? road.length : 0.0;
  const roadquery::PlanPoint p = roadquery::reference_point(road, s);
  const roadquery::Edges edges = lanes_at(road, s);
  const double middle = 0.5 * (edges.left_t + edges.right_t);
  const double half = 0.5 * std::max(edges.left_t - edges.right_t, least_width_m);
  // The slope along the road of the line of least squares (section_at), where it passes the reference line.
  double sum = 0.0, moment = 0.0, square = 0.0;
  for (int i = 0; i < across; ++i) {
    const double off = half * (2.0 * i / (across - 1) - 1.0), t = middle + off;
    const roadquery::JunctionHeight h =
        roadquery::evaluate(surface, p.x - t * std::sin(p.hdg), p.y + t * std::cos(p.hdg));
    const double slope = (h.dz_dx * std::cos(p.hdg) + h.dz_dy * std::sin(p.hdg)) * (1.0 - p.curvature * t);
    sum += slope, moment += off * slope, square += off * off;
  }
  const Section section = section_at(road, surface, s);
  return {section.z, sum / across - middle * moment / square, section.bank};
}

Road refitted(const Road& road, const roadquery::JunctionSurface& surface, const ProfileEnds& ends) {
  constexpr double shortest_m = 0.1;
  if (road.length < shortest_m) return road;
  const Wanted wanted = wanted_of(road, surface, ends);
  Course z{{}, ends.start.gradient, ends.end.gradient, share * tolerance_m};
  Course bank{{}, wanted.start_rate, wanted.end_rate, (1.0 - share) * tolerance_m / wanted.half_m};
  for (const Section& section : wanted.sections) z.values.push_back(section.z), bank.values.push_back(section.bank);
  Road fitted = road;
  fitted.elevation = cubics_of(through(z, wanted.step_m));
  fitted.superelevation = cubics_of(through(bank, wanted.step_m));
  const auto level = [](const Cubic& c) { return c.a == 0.0 && c.b == 0.0 && c.c == 0.0 && c.d == 0.0; };
  if (std::all_of(fitted.superelevation.begin(), fitted.superelevation.end(), level)) fitted.superelevation.clear();
  return fitted;
}

}  // namespace orthodrive::network
