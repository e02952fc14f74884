// SPDX-License-Identifier: Apache-2.0
// The first guess of refine: exact on a coarse grid. Profiles are made by hand: cells of 0.25 m, a road where told.

#include "orthodrive/refine/search_offsets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

#include "orthodrive/core/random.hpp"
#include "orthodrive/refine/parallel_roads.hpp"

namespace orthodrive::refine {
namespace {

constexpr double step_m = 0.25, half_m = 16.0, width_m = 6.0;
constexpr int width_levels = 13;

RoadChain straight_chain(std::size_t segments) {
  RoadChain chain;
  for (std::size_t i = 0; i <= segments; ++i)
    chain.nodes.push_back({.base = {2.0 * static_cast<double>(i), 0.0},
                           .normal = {0.0, 1.0},
                           .s_m = 2.0 * static_cast<double>(i),
                           .input_width_m = width_m,
                           .width_sigma_m = 1.0});
  chain.pieces = {{.path = 0, .first = 0, .last = segments}};
  return chain;
}

/// `is_road(segment, t)` at the middle of each cell; `evidence` 0..1 of all rows.
CrossProfiles make_profiles(std::size_t segments, const std::function<double(std::size_t, double)>& road,
                            double evidence = 1.0) {
  CrossProfiles profiles{.step_m = step_m, .half_m = half_m, .cells = static_cast<int>(2.0 * half_m / step_m)};
  for (std::size_t row = 0; row < segments * rows_per_segment; ++row) {
    for (int k = 0; k < profiles.cells; ++k) {
      const double share = road(row / rows_per_segment, (k + 0.5) * step_m - half_m);
      profiles.false_positive.push_back(static_cast<float>(share));
      profiles.false_negative.push_back(static_cast<float>(1.0 - share));
    }
    profiles.chain_evidence.push_back({evidence, evidence});
    profiles.evidence.push_back({evidence, evidence});
    profiles.road_near.push_back(true);
  }
  return profiles;
}

std::function<double(std::size_t, double)> road_between(double right_m, double left_m) {
  return [=](std::size_t, double t) { return t > right_m && t < left_m ? 1.0 : 0.0; };
}

TEST(SearchOffsets, finds_a_road_beside_the_map_and_its_width) {
  const RoadChain chain = straight_chain(30);
  const ChainShape shape = search_offsets(chain, make_profiles(30, road_between(-0.5, 5.5)), {}, {});
  EXPECT_THAT(shape.offset_m, testing::Each(testing::DoubleNear(2.5, 0.25)));
  EXPECT_THAT(shape.width_m, testing::Each(testing::DoubleNear(6.0, 0.35)));  // levels are 0.65 m apart
  ASSERT_EQ(shape.offset_m.size(), chain.nodes.size());
}

TEST(SearchOffsets, a_road_does_not_hide_where_a_merging_one_is) {
  // The labels show road on both sides and doubt the one between: any place of the left edge leaves road beside it, but
  // for those to the right of the line, where nothing counts.
  const RoadChain chain = straight_chain(30);
  const RefineRoadsOptions options;
  CrossProfiles profiles = make_profiles(30, [](std::size_t, double t) {
    return std::abs(t) > 12.0 ? 0.0 : std::abs(t) < 3.0 ? 0.7 : 1.0;
  });
  std::vector<Merging> merging;
  for (std::size_t i = 0; i < 30; ++i) merging.push_back({i, -1.0});
  const std::vector<ExpectedOffset> expected(31, {0.0, 3.0});
  silence_merging(chain, merging, {}, options, profiles);
  const ChainShape shape = search_offsets(chain, profiles, expected, options);
  EXPECT_THAT(shape.offset_m, testing::Each(testing::Gt(-4.0)));
}

/// The exact optimum, by trying all paths. Costs are counted cell by cell.
struct BruteForce {
  const CrossProfiles& profiles;
  const std::vector<ExpectedOffset>& expected;
  const RefineRoadsOptions& options;
  int offsets;

  [[nodiscard]] double offset_m(int state) const {
    const int level = state / width_levels - offsets / 2;
    return level * 0.5;
  }
  [[nodiscard]] double factor(int state) const {
    return options.min_width_factor +
           (state % width_levels) * (options.max_width_factor - options.min_width_factor) / (width_levels - 1);
  }
  [[nodiscard]] double state_cost(std::size_t segment, int state) const {
    const double offset = offset_m(state), half = 0.5 * factor(state) * width_m;
    double cost = 0.0, evidence = 0.0;
    for (std::size_t r = 0; r < rows_per_segment; ++r) {
      const std::size_t row = segment * rows_per_segment + r;
      const double left = profiles.evidence[row].left / static_cast<double>(rows_per_segment),
                   right = profiles.evidence[row].right / static_cast<double>(rows_per_segment);
      evidence += 0.5 * (left + right);
      const auto cell = [&](double t) { return std::lround((t + half_m) / step_m); };
      for (long k = 0; k < profiles.cells; ++k) {
        const double inside = profiles.negative_row(row)[static_cast<std::size_t>(k)],
                     outside = profiles.positive_row(row)[static_cast<std::size_t>(k)];
        if (k >= cell(offset - half) && k < cell(offset)) cost += right * inside * step_m;
        if (k >= cell(offset) && k < cell(offset + half)) cost += left * inside * step_m;
        if (k >= cell(offset + half) && k < cell(offset + half + 2.0)) cost += left * outside * step_m;
        if (k >= cell(offset - half - 2.0) && k < cell(offset - half)) cost += right * outside * step_m;
      }
    }
    const RefineWeights& w = options.weights;
    return cost +
           (0.02 + 0.98 * evidence) * (std::pow(offset - expected[segment].offset_m, 2) /
                                           (std::pow(w.search_offset_m, 2) + std::pow(expected[segment].sigma_m, 2)) +
                                       std::pow((factor(state) - 1.0) / w.search_width_share, 2));
  }
  [[nodiscard]] double step_cost(int a, int b) const {
    const int d = std::abs(a / width_levels - b / width_levels), e = std::abs(a % width_levels - b % width_levels);
    return d > 1 || e > 1 ? std::numeric_limits<double>::infinity() : options.weights.search_step * (d + e);
  }
};

TEST(SearchOffsets, equals_the_best_of_all_paths) {
  RefineRoadsOptions options;
  options.search_radius_m = 0.5;  // three offsets, so that 39^3 paths are all
  const RoadChain chain = straight_chain(3);
  Random random(11);
  for (int trial = 0; trial < 5; ++trial) {
    const double middle = random.uniform() - 0.5;
    CrossProfiles profiles = make_profiles(3, [&](std::size_t segment, double t) {
      const double half = 2.0 + 0.8 * static_cast<double>(segment);
      return std::abs(t - middle) < half ? 0.6 + 0.4 * random.uniform() : 0.4 * random.uniform();
    });
    for (EdgeEvidence& evidence : profiles.evidence) evidence = {random.uniform(), random.uniform()};
    const std::vector<ExpectedOffset> expected{{0.4, 0.3}, {0.1, 0.0}, {-0.2, 1.0}, {0.0, 0.0}};
    const BruteForce all{profiles, expected, options, 3};
    const int states = 3 * width_levels;
    std::vector<std::vector<double>> cost(3, std::vector<double>(static_cast<std::size_t>(states)));
    for (std::size_t segment = 0; segment < 3; ++segment)
      for (int s = 0; s < states; ++s) cost[segment][static_cast<std::size_t>(s)] = all.state_cost(segment, s);
    double least = std::numeric_limits<double>::infinity();
    std::array<int, 3> best{};
    for (int a = 0; a < states; ++a)
      for (int b = 0; b < states; ++b)
        for (int c = 0; c < states; ++c) {
          const double total = cost[0][static_cast<std::size_t>(a)] + cost[1][static_cast<std::size_t>(b)] +
                               cost[2][static_cast<std::size_t>(c)] + all.step_cost(a, b) + all.step_cost(b, c);
          if (total < least) least = total, best = {a, b, c};
        }
    // Nodes are means of the segments beside them; then means over as many nodes to both sides.
    const auto shaped = [&](const auto& value) {
      const std::array<double, 4> node{value(best[0]), 0.5 * (value(best[0]) + value(best[1])),
                                       0.5 * (value(best[1]) + value(best[2])), value(best[2])};
      return std::vector{node[0], (node[0] + node[1] + node[2]) / 3.0, (node[1] + node[2] + node[3]) / 3.0, node[3]};
    };
    const ChainShape shape = search_offsets(chain, profiles, expected, options);
    EXPECT_THAT(shape.offset_m,
                testing::Pointwise(testing::DoubleNear(1e-12), shaped([&](int s) { return all.offset_m(s); })));
    EXPECT_THAT(shape.width_m,
                testing::Pointwise(testing::DoubleNear(1e-9), shaped([&](int s) { return all.factor(s) * width_m; })));
  }
}

TEST(SearchOffsets, stays_within_the_search_radius_and_the_width_factors) {
  const RoadChain chain = straight_chain(20);
  RefineRoadsOptions options;
  options.search_radius_m = 2.3;  // four levels of 0.5 m to each side
  const ChainShape far = search_offsets(chain, make_profiles(20, road_between(1.0, 7.0)), {}, options);
  EXPECT_THAT(far.offset_m, testing::Each(testing::AllOf(testing::Ge(1.5), testing::Le(2.0))));
  const ChainShape wide = search_offsets(chain, make_profiles(20, road_between(-15.0, 15.0)), {}, options);
  EXPECT_THAT(wide.width_m, testing::Each(testing::Le(options.max_width_factor * width_m + 1e-9)));
  const ChainShape none = search_offsets(chain, make_profiles(20, road_between(0.0, 0.0)), {}, options);
  EXPECT_THAT(none.width_m, testing::Each(testing::Ge(options.min_width_factor * width_m - 1e-9)));
}

TEST(SearchOffsets, follows_what_is_expected_where_nothing_is_seen) {
  const RoadChain chain = straight_chain(20);
  const CrossProfiles unseen = make_profiles(20, road_between(-3.0, 3.0), 0.0F);
  const ChainShape shape = search_offsets(chain, unseen, std::vector<ExpectedOffset>(21, {3.1, 0.5}), {});
  EXPECT_THAT(shape.offset_m, testing::Each(testing::DoubleNear(3.0, 1e-9))) << "the nearest level";
  const ChainShape plain = search_offsets(chain, unseen, {}, {});
  EXPECT_THAT(plain.offset_m, testing::Each(testing::DoubleNear(0.0, 1e-9)));
  EXPECT_THAT(plain.width_m, testing::Each(testing::DoubleNear(width_m, 0.33)));
}

TEST(SearchOffsets, of_two_equal_roads_it_takes_one_and_the_same_every_time) {
  const RoadChain chain = straight_chain(20);
  const CrossProfiles two = make_profiles(20, [](std::size_t, double t) {
    return std::abs(std::abs(t) - 4.0) < 3.0 ? 1.0 : 0.0;  // 1..7 m to both sides
  });
  const ChainShape shape = search_offsets(chain, two, {}, {});
  const double side = shape.offset_m.front() > 0.0 ? 1.0 : -1.0;
  EXPECT_THAT(shape.offset_m, testing::Each(testing::DoubleNear(4.0 * side, 0.3)));
  EXPECT_EQ(shape.offset_m, search_offsets(chain, two, {}, {}).offset_m);
}

TEST(SearchOffsets, a_chain_of_two_nodes_is_one_segment) {
  const ChainShape shape = search_offsets(straight_chain(1), make_profiles(1, road_between(-2.0, 4.0)), {}, {});
  EXPECT_THAT(shape.offset_m, testing::ElementsAre(testing::DoubleNear(1.0, 0.26), testing::DoubleNear(1.0, 0.26)));
  EXPECT_EQ(shape.offset_m[0], shape.offset_m[1]);
}

}  // namespace
}  // namespace orthodrive::refine
