// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/banking/design_banking.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/model/roads/design_limits.hpp"
#include "orthodrive/model/roads/highway_class.hpp"

namespace orthodrive::elevate {
namespace {

struct SpeedRow {
  double speed_kmh, running_kmh, friction, relative_gradient;
};
// Green Book 2011, metric: average running speed (table 3-6), maximum side friction (3-7), maximum relative gradient
// (3-15).
constexpr std::array rows{
    SpeedRow{20, 20, 0.35, 0.0080},  SpeedRow{30, 30, 0.28, 0.0075},  SpeedRow{40, 40, 0.23, 0.0070},
    SpeedRow{50, 47, 0.19, 0.0065},  SpeedRow{60, 55, 0.17, 0.0060},  SpeedRow{70, 63, 0.15, 0.0055},
    SpeedRow{80, 70, 0.14, 0.0050},  SpeedRow{90, 77, 0.13, 0.0047},  SpeedRow{100, 85, 0.12, 0.0044},
    SpeedRow{110, 91, 0.11, 0.0041}, SpeedRow{120, 98, 0.09, 0.0038}, SpeedRow{130, 102, 0.08, 0.0035}};
constexpr double keeps_crown_below = 0.015;  // Green Book: curves that need less than 1.5 % keep the crown
constexpr double narrowest_half_width_m = 2.0;

SpeedRow at_speed(double speed_kmh) {
  const double v = std::clamp(speed_kmh, rows.front().speed_kmh, rows.back().speed_kmh);
  const auto i = std::min(static_cast<std::size_t>((v - 20.0) / 10.0), rows.size() - 2);
  const double f = (v - rows[i].speed_kmh) / 10.0;
  const auto mix = [&](double SpeedRow::*member) { return rows[i].*member * (1.0 - f) + rows[i + 1].*member * f; };
  return {v, mix(&SpeedRow::running_kmh), mix(&SpeedRow::friction), mix(&SpeedRow::relative_gradient)};
}

/// No change faster than `rate` (1/m) a metre: the mean of the lower and the upper Lipschitz envelope, so that a jump
/// becomes a ramp with its middle at the jump.
void limit_rate(std::vector<double>& values, const StationChain& chain, const std::vector<double>& rate) {
  const std::size_t n = values.size();
  std::vector<double> low = values, high = values;
  const auto spread = [&](std::size_t from, std::size_t to, std::size_t step) {
    const double change = step_m(chain, step) * std::min(rate[from], rate[to]);
    low[to] = std::max(low[to], low[from] - change);  // the largest of value - rate distance: lies above
    high[to] = std::min(high[to], high[from] + change);
  };
  for (int round = 0; round < (chain.closed ? 2 : 1); ++round) {  // the second time past the seam
    for (std::size_t i = 0; i + 1 < n; ++i) spread(i, i + 1, i);
    if (chain.closed) spread(n - 1, 0, n - 1);
  }
  for (int round = 0; round < (chain.closed ? 2 : 1); ++round) {
    for (std::size_t i = n - 1; i > 0; --i) spread(i, i - 1, i - 1);
    if (chain.closed) spread(0, n - 1, n - 1);
  }
  for (std::size_t i = 0; i < n; ++i) values[i] = 0.5 * (low[i] + high[i]);
}

}  // namespace

CurveRule curve_rule(const std::string& highway) {
  const DesignLimits limits = design_limits(highway);
  const double speed = limits.design_speed_kmh;
  if (is_raceway(highway)) return {speed, 0.0, true};
  if (limits.is_local) return {speed, 0.025, true};
  return {speed, speed >= 70.0 ? 0.07 : 0.06, false};
}

double curve_banking(const CurveRule& rule, double curvature_1pm) {
  const double k = std::abs(curvature_1pm), largest = rule.largest;
  if (largest <= 0.0) return 0.0;
  const SpeedRow v = at_speed(rule.design_speed_kmh);
  const double demand = v.speed_kmh * v.speed_kmh / 127.0 * k;  // e + f
  const double k_max = 127.0 * (largest + v.friction) / (v.speed_kmh * v.speed_kmh);
  if (k >= k_max) return largest;
  if (rule.friction_first) return std::clamp(demand - v.friction, 0.0, largest);
  // Method 5: a driver at running speed needs no side friction up to the point of intersection; two parabolas round the
  // corner.
  const double k_pi = 127.0 * largest / (v.running_kmh * v.running_kmh);
  const double h_pi = largest * (v.speed_kmh * v.speed_kmh / (v.running_kmh * v.running_kmh) - 1.0);
  const double s1 = h_pi / k_pi, s2 = (v.friction - h_pi) / (k_max - k_pi);
  const double middle = k_pi * (k_max - k_pi) * (s2 - s1) / (2.0 * k_max);
  const double friction = k <= k_pi ? middle * std::pow(k / k_pi, 2) + s1 * k
                                    : middle * std::pow((k_max - k) / (k_max - k_pi), 2) + h_pi + s2 * (k - k_pi);
  return std::clamp(demand - friction, 0.0, largest);
}

DesignBanking design_banking(const RoadNetwork& roads, const StationChain& chain, double crown,
                             DrivingSide driving_side) {
  const std::size_t n = chain.stations.size();
  DesignBanking design{std::vector<double>(n, 0.0), std::vector<double>(n, 0.0)};
  std::vector<double> rate(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Station& station = chain.stations[i];
    const RoadPath& path = roads.paths[station.path];
    rate[i] = at_speed(design_limits(path.highway).design_speed_kmh).relative_gradient /
              std::max(narrowest_half_width_m, station.half_width_m);
    if (is_raceway(path.highway)) continue;
    const bool one_way = path.oneway != Oneway::no || path.roundabout;
    const double e = path.roundabout ? 0.0 : curve_banking(curve_rule(path.highway), station.curvature_1pm);
    if (e >= keeps_crown_below)
      design.slope[i] = -std::copysign(std::max(e, crown), station.curvature_1pm);
    else if (one_way)
      design.slope[i] = (driving_side == DrivingSide::left) == station.against ? crown : -crown;
    if (!one_way) design.crown[i] = crown;
  }
  limit_rate(design.slope, chain, rate);
  limit_rate(design.crown, chain, rate);
  for (std::size_t i = 0; i < n; ++i) design.crown[i] = std::max(0.0, design.crown[i] - std::abs(design.slope[i]));
  return design;
}

}  // namespace orthodrive::elevate
