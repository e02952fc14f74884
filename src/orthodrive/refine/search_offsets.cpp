// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/search_offsets.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/refine/level_search.hpp"

namespace orthodrive::refine {
namespace {

constexpr double offset_step_m = 0.5;
constexpr int width_levels = 13;   // between the smallest and the largest width factor
constexpr double context_m = 2.0;  // road in such a strip beside the road counts as missed

struct Levels {
  int offsets = 0;  // odd: the middle one is 0
  double lowest_factor = 0.0, factor_step = 0.0;

  [[nodiscard]] int states() const { return offsets * width_levels; }
  [[nodiscard]] double offset_m(int state) const {
    const int level = state / width_levels - offsets / 2;
    return level * offset_step_m;
  }
  [[nodiscard]] double width_factor(int state) const { return lowest_factor + (state % width_levels) * factor_step; }
};

/// Sums over cells 0 .. k-1: the cost between two lateral positions is a difference of two sums.
std::vector<double> running_sums(std::span<const float> costs, double step_m) {
  std::vector<double> sums(costs.size() + 1, 0.0);
  for (std::size_t k = 0; k < costs.size(); ++k) sums[k + 1] = sums[k] + costs[k] * step_m;
  return sums;
}

/// Where the sums of a row are read for a state: at its edges, and beyond them.
struct StateKnots {
  std::size_t right = 0, middle = 0, left = 0, beyond_right = 0, beyond_left = 0;
};

/// For every state of roads of that width.
std::vector<StateKnots> knots_of(const CrossProfiles& profiles, double input_width_m, const Levels& levels) {
  const auto knot = [&](double t) {
    return static_cast<std::size_t>(
        std::clamp<long>(std::lround((t + profiles.half_m) / profiles.step_m), 0, profiles.cells));
  };
  std::vector<StateKnots> knots;
  for (int state = 0; state < levels.states(); ++state) {
    const double offset = levels.offset_m(state), half = 0.5 * levels.width_factor(state) * input_width_m;
    knots.push_back({knot(offset - half), knot(offset), knot(offset + half), knot(offset - half - context_m),
                     knot(offset + half + context_m)});
  }
  return knots;
}

/// Adds the misclassified width of one row to the cost of every state: of each half of the road as much as its edge
/// counts.
void add_row_cost(const CrossProfiles& profiles, std::size_t row, const std::vector<StateKnots>& knots,
                  std::vector<double>& cost) {
  const auto positive = running_sums(profiles.positive_row(row), profiles.step_m);
  const auto negative = running_sums(profiles.negative_row(row), profiles.step_m);
  const double left = profiles.evidence[row].left / static_cast<double>(rows_per_segment),
               right = profiles.evidence[row].right / static_cast<double>(rows_per_segment);
  for (std::size_t state = 0; state < knots.size(); ++state) {
    const StateKnots& k = knots[state];
    cost[state] += left * (negative[k.left] - negative[k.middle] + positive[k.beyond_left] - positive[k.left]) +
                   right * (negative[k.middle] - negative[k.right] + positive[k.right] - positive[k.beyond_right]);
  }
}

/// Levels are steps. From a line without corners the fit converges in half the iterations.
std::vector<double> running_mean(const std::vector<double>& values) {
  constexpr std::ptrdiff_t reach = 4;
  const std::ptrdiff_t count = std::ssize(values);
  std::vector<double> means;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const std::ptrdiff_t near = std::min({reach, i, count - 1 - i});  // symmetric, so that a slope stays
    double sum = 0.0;
    for (std::ptrdiff_t k = i - near; k <= i + near; ++k) sum += values[static_cast<std::size_t>(k)];
    means.push_back(sum / static_cast<double>(2 * near + 1));
  }
  return means;
}

/// What the levels of one segment cost: misclassified width, and the pull to the expected offset and the input's width.
std::vector<double> segment_costs(const RoadChain& chain, const CrossProfiles& profiles, std::size_t segment,
                                  const ExpectedOffset& expected, const RefineWeights& weights, const Levels& levels,
                                  const std::vector<StateKnots>& knots) {
  // Where nothing is measured the pull must not win over the neighbours' offset: it counts with the evidence.
  double evidence = 0.0;
  for (std::size_t r = 0; r < rows_per_segment; ++r)
    evidence += profiles.evidence[segment * rows_per_segment + r].mean() / rows_per_segment;
  const double width_share = weights.search_width_share * looseness(chain.nodes[segment]);
  const double offset_scale_m2 = std::pow(weights.search_offset_m, 2) + std::pow(expected.sigma_m, 2);
  std::vector<double> cost(static_cast<std::size_t>(levels.states()));
  for (int state = 0; state < levels.states(); ++state) {
    const double width_prior = std::pow((levels.width_factor(state) - 1.0) / width_share, 2);
    cost[state] = (0.02 + 0.98 * evidence) *
                  (std::pow(levels.offset_m(state) - expected.offset_m, 2) / offset_scale_m2 + width_prior);
  }
  for (std::size_t r = 0; r < rows_per_segment; ++r) {
    const std::size_t row = segment * rows_per_segment + r;
    if (profiles.evidence[row].mean() > 0.0) add_row_cost(profiles, row, knots, cost);
  }
  return cost;
}

/// A node lies between two segments: the mean of their levels.
ChainShape shape_of(const RoadChain& chain, const std::vector<int>& states, const Levels& levels) {
  ChainShape shape;
  for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
    const int before = states[i == 0 ? 0 : i - 1], after = states[std::min(i, states.size() - 1)];
    shape.offset_m.push_back(0.5 * (levels.offset_m(before) + levels.offset_m(after)));
    shape.width_m.push_back(0.5 * (levels.width_factor(before) + levels.width_factor(after)) *
                            chain.nodes[i].input_width_m);
  }
  return shape;
}

}  // namespace

double looseness(const ChainNode& node) {
  constexpr double usual_share = 0.3;  // the largest sigma of a default width (roads/road_chains)
  return std::max(1.0, node.width_sigma_m / (usual_share * node.input_width_m));
}

double max_width_factor(const ChainNode& node, const RefineRoadsOptions& options) {
  constexpr double most = 2.5;
  return std::max(options.max_width_factor, std::min(most, options.max_width_factor * looseness(node)));
}

ChainShape search_offsets(const RoadChain& chain, const CrossProfiles& profiles,
                          const std::vector<ExpectedOffset>& expected, const RefineRoadsOptions& options) {
  double largest_factor = options.max_width_factor;
  for (const ChainNode& node : chain.nodes) largest_factor = std::max(largest_factor, max_width_factor(node, options));
  const Levels levels{2 * static_cast<int>(options.search_radius_m / offset_step_m) + 1, options.min_width_factor,
                      (largest_factor - options.min_width_factor) / (width_levels - 1)};
  LevelSearch search(levels.offsets, width_levels, options.weights.search_step);
  std::vector<StateKnots> knots;
  for (std::size_t segment = 0; segment + 1 < chain.nodes.size(); ++segment) {
    const double width_m = chain.nodes[segment].input_width_m;
    if (segment == 0 || width_m != chain.nodes[segment - 1].input_width_m) knots = knots_of(profiles, width_m, levels);
    search.add_segment(segment_costs(chain, profiles, segment, expected.empty() ? ExpectedOffset{} : expected[segment],
                                     options.weights, levels, knots));
  }
  ChainShape shape = shape_of(chain, search.cheapest(), levels);
  shape.offset_m = running_mean(shape.offset_m);
  shape.width_m = running_mean(shape.width_m);
  return shape;
}

}  // namespace orthodrive::refine
