// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/roads/evaluate_heights.hpp"

#include <cmath>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/evaluate/labels/no_value.hpp"
#include "orthodrive/evaluate/roads/roads_across.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"

namespace orthodrive {
namespace {

/// What the truth says at a node; NaN where it says nothing.
struct TrueProfile {
  double z_m = no_value, gradient = no_value, banking = no_value;
};

/// truth(path, node, unit tangent) -> TrueProfile.
template <typename Truth>
HeightScores compare(const RoadNetwork& roads, const ScoreRegion& region, Truth&& truth) {
  std::vector<double> z_errors, gradient_errors, banking_errors;
  double gradient_squares = 0.0, height_squares = 0.0, true_squares = 0.0, difference_squares = 0.0;
  std::size_t segments = 0;
  SigmaCount sigma;
  HeightScores scores;
  const auto add = [](std::vector<double>& errors, double ours, double expected) {
    if (!std::isnan(expected)) errors.push_back(ours - expected);
  };
  for (const RoadPath& path : roads.paths) {
    const std::vector<Vec2> directions = tangents(centerline(path));
    for (std::size_t i = 0; i < path.nodes.size(); ++i) {
      const RoadNode& node = path.nodes[i];
      if (std::isnan(node.z_m) || !region.contains(node.p)) continue;
      const std::optional<TrueProfile> expected = truth(path, node, directions[i]);
      if (!expected) continue;
      ++scores.nodes;
      if (i + 1 < path.nodes.size()) {
        const RoadNode& next = path.nodes[i + 1];
        const double run_m = distance(node.p, next.p);
        if (run_m > 0.0 && !std::isnan(next.z_m))
          gradient_squares += std::pow((next.z_m - node.z_m) / run_m, 2), ++segments;
      }
      if (std::isnan(expected->z_m)) continue;
      add(z_errors, node.z_m, expected->z_m);
      add(gradient_errors, node.gradient, expected->gradient);
      add(banking_errors, node.banking, expected->banking);
      height_squares += z_errors.back() * z_errors.back();
      sigma.add(z_errors.back(), node.sigma_z_m);
      if (std::isnan(expected->gradient)) continue;
      true_squares += expected->gradient * expected->gradient;
      difference_squares += std::pow(node.gradient - expected->gradient, 2);
    }
  }
  scores.z_m = summarize(z_errors);
  scores.gradient = summarize(gradient_errors);
  scores.banking = summarize(banking_errors);
  const auto mean = [](double sum, std::size_t n) { return n == 0 ? no_value : sum / static_cast<double>(n); };
  scores.gradient_energy = mean(gradient_squares, segments);
  scores.true_gradient_energy = mean(true_squares, gradient_errors.size());
  scores.gradient_error_energy = mean(difference_squares, gradient_errors.size());
  scores.height_error_energy_m2 = mean(height_squares, z_errors.size());
  scores.compared_share = mean(static_cast<double>(z_errors.size()), scores.nodes);
  scores.sigma = sigma.coverage();
  scores.shape = measure_profile_shape(roads, region);
  return scores;
}
}  // namespace

HeightScores evaluate_heights(const RoadNetwork& roads, const HeightGrid& terrain, const ScoreRegion& region) {
  if (terrain.crs != roads.crs)
    throw OptionError("the terrain model is in " + terrain.crs.definition + ", the roads are in " +
                      roads.crs.definition);
  return compare(
      roads, region, [&](const RoadPath& path, const RoadNode& node, Vec2 direction) -> std::optional<TrueProfile> {
        if (path.bridge || path.tunnel) return {};
        const double step_m = terrain.frame.gsd_m, half_m = 0.5 * node.width_m;
        const Vec2 ahead = step_m * direction, left = half_m * left_normal(direction);
        TrueProfile profile{.z_m = sample_bilinear(terrain, node.p)};
        profile.gradient =
            (sample_bilinear(terrain, node.p + ahead) - sample_bilinear(terrain, node.p - ahead)) / (2.0 * step_m);
        if (half_m > 0.0)
          profile.banking = std::atan(
              (sample_bilinear(terrain, node.p + left) - sample_bilinear(terrain, node.p - left)) / (2.0 * half_m));
        return profile;
      });
}

HeightScores evaluate_heights(const RoadNetwork& roads, const RoadNetwork& truth, const ScoreRegion& region) {
  if (truth.crs != roads.crs)
    throw OptionError("the true roads are in " + truth.crs.definition + ", the roads are in " + roads.crs.definition);
  const evaluate::RoadsAcross index(truth);
  return compare(
      roads, region, [&](const RoadPath& path, const RoadNode& node, Vec2 direction) -> std::optional<TrueProfile> {
        const auto at = index.find({.p = node.p, .direction = direction, .reach_m = 10.0, .layer = path.layer});
        if (!at) return TrueProfile{};
        const double sign = at->same_direction ? 1.0 : -1.0;
        TrueProfile profile;
        profile.gradient = sign * evaluate::interpolate(truth, *at, &RoadNode::gradient);
        profile.banking = sign * evaluate::interpolate(truth, *at, &RoadNode::banking);
        // The node lies beside the true line (its left is positive offset): the true surface there, not on the line.
        profile.z_m = evaluate::interpolate(truth, *at, &RoadNode::z_m) - at->offset_m * std::tan(profile.banking);
        return profile;
      });
}

}  // namespace orthodrive
