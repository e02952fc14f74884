// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/ease_along.hpp"

#include <cmath>

#include "orthodrive/network/curves/fit_profile.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double curvature_jump = 1e-3;  // 1/m: a lane of slope 0.3 and 4 m beside the line turns by 0.07 degrees

/// Where the stretches without a jump begin, and the end of the line.
std::vector<double> stretches_of(std::span<const roadquery::PlanElement> plan) {
  std::vector<double> borders{0.0};
  for (std::size_t i = 0; i + 1 < plan.size(); ++i) {
    const double before = roadquery::evaluate(plan[i], plan[i].length).curvature;
    const double after = roadquery::evaluate(plan[i + 1], 0.0).curvature;
    if (std::abs(after - before) > curvature_jump) borders.push_back(plan[i + 1].s);
  }
  borders.push_back(plan.back().s + plan.back().length);
  return borders;
}

}  // namespace

std::vector<roadquery::Cubic> ease_along(std::span<const roadquery::PlanElement> plan, double from, double to) {
  if (from == to) return {{0.0, from, 0.0, 0.0, 0.0}};
  const std::vector<double> borders = stretches_of(plan);
  const auto square_of = [&](std::size_t i) { return std::pow(borders[i + 1] - borders[i], 2); };
  double squares = 0.0;
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) squares += square_of(i);
  std::vector<roadquery::Cubic> result;
  result.reserve(borders.size() - 1);
  double begin = from, sum = 0.0;
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) {
    sum += square_of(i);
    const double end = i + 2 < borders.size() ? from + (to - from) * sum / squares : to;
    result.push_back(hermite(borders[i], borders[i + 1], begin, end, 0.0, 0.0));
    begin = end;
  }
  return result;
}

}  // namespace orthodrive::network
