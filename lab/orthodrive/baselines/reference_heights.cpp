// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/reference_heights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/math/robust_fit.hpp"

namespace orthodrive {

NodeHeights moving_average(const RoadNetwork& roads, const NodeHeights& terrain_m, int window) {
  if (window < 1 || window % 2 == 0)
    throw OptionError(
        fmt::format("elevate: the window of the moving average is {} samples, need an odd number", window));
  NodeHeights result;
  for (std::size_t k = 0; k < terrain_m.size(); ++k) {
    const std::vector<double>& z = terrain_m[k];
    const auto n = static_cast<std::ptrdiff_t>(z.size());
    const bool closed = n > 3 && roads.paths[k].nodes.front().p == roads.paths[k].nodes.back().p;
    const std::ptrdiff_t period = n - 1;  // the last node of a closed way is its first
    auto& mean = result.emplace_back();
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const std::ptrdiff_t room = closed ? (period - 1) / 2 : std::min(i, n - 1 - i),
                           half = std::min<std::ptrdiff_t>(window / 2, room);
      double sum = 0.0;
      for (std::ptrdiff_t j = i - half; j <= i + half; ++j)
        sum += z[static_cast<std::size_t>(closed ? (j + period) % period : j)];
      mean.push_back(sum / static_cast<double>(2 * half + 1));
    }
  }
  return result;
}

SolvedHeights reference_heights(const RoadNetwork& roads, const NodeHeights& terrain_m,
                                const ReferenceHeightsOptions& options) {
  constexpr double weight_gradient = 1.2, weight_gradient_change = 12.0, weight_height = 0.2;  // table 3.5
  constexpr double shortest_run_m = 0.1;  // nodes on top of each other must not give endless gradients
  constexpr double step_tolerance_m = 1e-5;
  if (!(options.loss_m > 0.0))
    throw OptionError(fmt::format("elevate: the loss of the reference is {} m, need more than 0", options.loss_m));
  std::size_t unknowns = 0;
  for (const auto& z : terrain_m) unknowns += z.size();
  RobustFit fit(unknowns);
  std::vector<double> x;
  for (std::size_t k = 0; k < terrain_m.size(); ++k) {
    const auto& nodes = roads.paths[k].nodes;
    const int first = static_cast<int>(x.size());
    x.insert(x.end(), terrain_m[k].begin(), terrain_m[k].end());
    double run_before_m = 0.0;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const int here = first + static_cast<int>(n);
      fit.add_cauchy(std::array{Term{here, 1.0}}, terrain_m[k][n], weight_height * weight_height, options.loss_m);
      if (n + 1 == nodes.size()) break;
      const double run_m = std::max(shortest_run_m, distance(nodes[n].p, nodes[n + 1].p));
      const double g = weight_gradient / run_m, after = weight_gradient_change / run_m,
                   before = weight_gradient_change / run_before_m;
      fit.add_square(std::array{Term{here, -g}, Term{here + 1, g}}, 0.0, 1.0);
      if (n > 0)
        fit.add_square(std::array{Term{here - 1, before}, Term{here, -before - after}, Term{here + 1, after}}, 0.0,
                       1.0);
      run_before_m = run_m;
    }
  }
  const RobustFit::Summary solve = fit.solve(x, options.max_iterations, step_tolerance_m);
  SolvedHeights result{.solve = {solve.converged, solve.iterations, solve.cost_before, solve.cost_after}};
  auto from = x.begin();
  for (const auto& z : terrain_m) {
    result.z_m.emplace_back(from, from + static_cast<std::ptrdiff_t>(z.size()));
    from += static_cast<std::ptrdiff_t>(z.size());
  }
  return result;
}

}  // namespace orthodrive
