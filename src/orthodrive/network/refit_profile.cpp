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

constexpr double least_knot_m = 1.5, step_m = 0.5;
constexpr double tolerance_m = 0.005;  // more pieces until the lanes lie so near to the surface
constexpr int across = 5;              // places of a cross section
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

/// `fitted` gets cubics over so many pieces; at the ends height, gradient and banking stay those of `road`, which meets
/// its arms.
void fit(Road& fitted, const Road& road, const roadquery::JunctionSurface& surface, int pieces) {
  std::vector<double> knots, z, bank;
  for (int i = 0; i <= pieces; ++i) {
    const double s = road.length * i / pieces;
    const Section at = i == 0 || i == pieces
                           ? Section{roadquery::elevation(road, s), roadquery::superelevation(road, s)}
                           : section_at(road, surface, s);
    knots.push_back(s), z.push_back(at.z), bank.push_back(at.bank);
  }
  fitted.elevation =
      cubics_of(clamped_spline(knots, z, roadquery::gradient(road, 0.0), roadquery::gradient(road, road.length)));
  // A road that begins to turn at once turns its banking at once, too, however little the arm's changes.
  const auto rate = [&](double s, double step) {
    return (section_at(road, surface, s + step).bank - section_at(road, surface, s).bank) / step;
  };
  const double step = std::min(rate_step_m, 0.5 * road.length);
  fitted.superelevation =
      cubics_of(clamped_spline(std::move(knots), std::move(bank), rate(0.0, step), rate(road.length, -step)));
  const auto level = [](const Cubic& c) { return c.a == 0.0 && c.b == 0.0 && c.c == 0.0 && c.d == 0.0; };
  if (std::all_of(fitted.superelevation.begin(), fitted.superelevation.end(), level)) fitted.superelevation.clear();
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

Road refitted(const Road& road, const roadquery::JunctionSurface& surface) {
  constexpr double shortest_m = 0.1;
  if (road.length < shortest_m) return road;
  Road fitted = road;
  for (int pieces = 1;; pieces *= 2) {
    fit(fitted, road, surface, pieces);
    if (road.length < 2.0 * least_knot_m * pieces || distance_from_surface_m(fitted, surface) <= tolerance_m)
      return fitted;
  }
}

}  // namespace orthodrive::network
