// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/line/limit_warp.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double warp_step_m = 0.5;
constexpr double most_1pm = 0.013;  // 3.5 % in a wheelbase; what of RAS-L's 0.5 % roads on steep ground cannot keep
constexpr double least_inside = 0.2;

/// Places along a chain. Within a step the banking may change by `turn` (what a plane does) and `room` more or less.
struct Places {
  std::vector<double> s, slope, turn, room;
};

double plan_curvature_at(const std::vector<roadquery::PlanElement>& plan, double s) {
  auto element =
      std::upper_bound(plan.begin(), plan.end(), s, [](double v, const roadquery::PlanElement& e) { return v < e.s; });
  if (element != plan.begin()) --element;
  return roadquery::evaluate(*element, std::clamp(s - element->s, 0.0, element->length)).curvature;
}

Places sample(const ChainGeometry& geometry) {
  Places places;
  const auto steps = static_cast<int>(std::ceil(geometry.length_m / warp_step_m));
  for (int i = 0; i <= steps; ++i) {
    const double s = geometry.length_m * i / steps;
    places.s.push_back(s), places.slope.push_back(std::tan(value_at(geometry.superelevation, s)));
    if (i == steps) break;
    const double middle = s + 0.5 * geometry.length_m / steps, curvature = plan_curvature_at(geometry.plan, middle);
    // A metre of the lane inside a bend is more of the road's line, and the same turn is made in less of it.
    const double inside = std::max(least_inside, 1.0 - std::abs(curvature) * 0.25 * width_at(geometry, middle));
    places.turn.push_back(-curvature * slope_at(geometry.elevation, middle) * geometry.length_m / steps);
    places.room.push_back(most_1pm * inside * inside * geometry.length_m / steps);
  }
  return places;
}

/// The mean of the lowest profile that is nowhere below and the highest that is nowhere above, both slow enough.
std::vector<double> slowed(const Places& places, bool closed) {
  const std::size_t n = places.slope.size();
  std::vector<double> above = places.slope, below = places.slope;
  const auto spread = [&](std::size_t from, std::size_t to, double turn, double room) {
    above[to] = std::max(above[to], above[from] + turn - room);
    below[to] = std::min(below[to], below[from] + turn + room);
  };
  for (int round = 0; round < (closed ? 2 : 1); ++round) {  // the second one past the seam
    for (std::size_t i = 0; i + 1 < n; ++i) spread(i, i + 1, places.turn[i], places.room[i]);
    if (closed) spread(n - 1, 0, 0.0, 0.0);
  }
  for (int round = 0; round < (closed ? 2 : 1); ++round) {
    for (std::size_t i = n - 1; i > 0; --i) spread(i, i - 1, -places.turn[i - 1], places.room[i - 1]);
    if (closed) spread(0, n - 1, 0.0, 0.0);
  }
  for (std::size_t i = 0; i < n; ++i) above[i] = 0.5 * (above[i] + below[i]);
  return above;
}

}  // namespace

void limit_warp(ChainGeometry& geometry, double banking_tolerance_rad) {
  if (geometry.empty() || !(geometry.length_m > warp_step_m)) return;
  const Places places = sample(geometry);
  const std::vector<double> slope = slowed(places, geometry.closed);
  constexpr double nothing = 1e-9;
  double changed = 0.0;
  std::vector<ProfileSample> banking;
  for (std::size_t i = 0; i < slope.size(); ++i) {
    changed = std::max(changed, std::abs(slope[i] - places.slope[i]));
    banking.push_back({places.s[i], std::atan(slope[i])});
  }
  if (changed > nothing)
    geometry.superelevation = fit_profile(banking, {banking_tolerance_rad, geometry.closed}).cubics;
}

}  // namespace orthodrive::network
