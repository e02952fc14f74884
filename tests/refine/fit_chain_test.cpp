// SPDX-License-Identifier: Apache-2.0
// The fit of one chain on painted labels, and the profiles that it reads.

#include "orthodrive/refine/fit_chain.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "road_scene.hpp"

namespace orthodrive::refine {
namespace {

using namespace test;

/// A road of 6 m along y = 100, painted from x = 20 to 180; the map has it `map_y_m` beside.
struct StraightScene {
  explicit StraightScene(double map_y_m) {
    add_truth(scene, straight(at(20.0, 100.0), at(180.0, 100.0)), 6.0);
    add_way(scene, 1,
            {{.p = at(20.0, 100.0 + map_y_m), .width_m = 6.0}, {.p = at(180.0, 100.0 + map_y_m), .width_m = 6.0}});
    chain = build_chains(scene.osm, {.spacing_m = options.spacing_m}).at(0);
    profiles = sample_cross_profiles(chain, road_evidence(scene.labels), 20.0);
  }
  [[nodiscard]] ChainShape start(double offset_m = 0.0) const {
    return {std::vector<double>(chain.nodes.size(), offset_m), std::vector<double>(chain.nodes.size(), 6.0)};
  }
  [[nodiscard]] ChainFit fit(const ChainCoupling& coupling = {}) const {
    return fit_chain(chain, profiles, start(), coupling, options);
  }

  RefineRoadsOptions options;
  RoadScene scene = make_scene(200.0);
  RoadChain chain;
  CrossProfiles profiles;
};

TEST(FitChain, finds_the_painted_road) {
  const StraightScene s(-0.6);  // the map lies to the right of the road
  const ChainFit fit = s.fit();
  EXPECT_TRUE(fit.solve.converged);
  EXPECT_LT(fit.solve.cost_after, fit.solve.cost_before);
  for (std::size_t i = 5; i + 5 < s.chain.nodes.size(); ++i) {
    EXPECT_NEAR(fit.shape.offset_m[i], 0.6, 0.1);
    EXPECT_NEAR(fit.shape.width_m[i], 6.0, 0.25);
  }
  EXPECT_THAT(fit.sigma_offset_m, testing::Each(testing::AllOf(testing::Gt(0.0), testing::Lt(1.5))));
  EXPECT_THAT(fit.sigma_width_m, testing::Each(testing::AllOf(testing::Gt(0.0), testing::Lt(3.0))));
}

TEST(FitChain, a_hidden_stretch_takes_most_of_the_shift_and_the_width_of_its_way) {
  StraightScene s(-0.6);
  for (std::size_t row = 50; row < 90; ++row) s.profiles.evidence[row] = {0.0, 0.0};  // 40 m of 160 m
  const ChainFit fit = s.fit();
  for (std::size_t i = 27; i < 43; ++i) {
    EXPECT_GT(fit.shape.offset_m[i], 0.35) << "one way's shift has a prior of 0.2 m; the map's comes by `expected`";
    EXPECT_LT(fit.shape.offset_m[i], 0.65);
    EXPECT_NEAR(fit.shape.width_m[i], 6.0, 0.3);
  }
  EXPECT_GT(fit.sigma_offset_m[35], fit.sigma_offset_m[15]) << "less sure where nothing is seen";
  EXPECT_GT(fit.sigma_width_m[35], fit.sigma_width_m[15]);
}

TEST(FitChain, across_from_a_mouth_the_other_edge_tells_where_the_road_lies) {
  StraightScene s(-0.6);
  for (std::size_t row = 60; row < 80; ++row)  // 20 m of 160 m are road to the left, as far as one sees
    for (int k = 0; k < s.profiles.cells; ++k) {
      if ((k + 0.5) * s.profiles.step_m < s.profiles.half_m + 0.6) continue;
      const std::size_t cell = row * static_cast<std::size_t>(s.profiles.cells) + static_cast<std::size_t>(k);
      s.profiles.false_positive[cell] = 1.0F, s.profiles.false_negative[cell] = 0.0F;
    }
  const ChainFit hidden = [s]() mutable {
    for (std::size_t row = 60; row < 80; ++row) s.profiles.evidence[row] = {0.0, 0.0};
    return s.fit();
  }();
  for (std::size_t row = 60; row < 80; ++row) s.profiles.evidence[row] = {0.0, 1.0};
  const ChainFit fit = s.fit();
  for (std::size_t i = 30; i < 40; ++i) {
    EXPECT_NEAR(fit.shape.offset_m[i], 0.6, 0.1) << i;
    EXPECT_NEAR(fit.shape.width_m[i], 6.0, 0.25) << i;
  }
  EXPECT_LT(std::abs(fit.shape.offset_m[35] - 0.6), std::abs(hidden.shape.offset_m[35] - 0.6));
  EXPECT_LT(fit.sigma_offset_m[35], hidden.sigma_offset_m[35]);
}

TEST(FitChain, is_less_sure_where_edges_are_soft) {
  StraightScene s(0.0);
  const ChainFit sharp = s.fit();
  const auto cells = static_cast<std::size_t>(s.profiles.cells);
  for (std::size_t row = 80; row < s.profiles.evidence.size(); ++row)  // the second half of the road
    for (std::size_t k = 0; k < cells; ++k) {
      const double t = (static_cast<double>(k) + 0.5) * s.profiles.step_m - s.profiles.half_m,
                   road = 1.0 / (1.0 + std::exp((std::abs(t) - 3.0) / 0.45));  // a band of 1.8 m at each edge
      s.profiles.false_positive[row * cells + k] = static_cast<float>(road);
      s.profiles.false_negative[row * cells + k] = static_cast<float>(1.0 - road);
    }
  const ChainFit soft = s.fit();
  EXPECT_NEAR(soft.shape.width_m[60], 6.0, 0.3);
  EXPECT_GT(soft.sigma_offset_m[60], 1.0);
  EXPECT_GT(soft.sigma_width_m[60], 2.0);
  EXPECT_LT(sharp.sigma_offset_m[60], 0.7);
  EXPECT_LT(soft.sigma_offset_m[20], 0.7) << "the first half is as sharp as before";
}

/// A hairpin of a radius of 7 m between straights of 40 m. Nothing is painted; the evidence says so.
TEST(FitChain, keeps_a_hidden_hairpin_near_the_map) {
  RefineRoadsOptions options;
  RoadScene scene = make_scene(200.0);
  constexpr double radius_m = 7.0, straight_m = 40.0, bend_m = M_PI * radius_m;
  std::vector<RoadNode> nodes;
  for (double s = 0.0; s <= 2.0 * straight_m + bend_m; s += 2.0) {
    const double angle = std::clamp((s - straight_m) / radius_m, 0.0, M_PI);
    const double along_m = s < straight_m ? s : s > straight_m + bend_m ? 2.0 * straight_m + bend_m - s : straight_m;
    nodes.push_back(
        {.p = at(50.0 + along_m + radius_m * std::sin(angle), 100.0 - radius_m * std::cos(angle)), .width_m = 4.0});
  }
  add_way(scene, 1, nodes);
  const RoadChain chain = build_chains(scene.osm, {.spacing_m = options.spacing_m}).at(0);
  CrossProfiles profiles = sample_cross_profiles(chain, road_evidence(scene.labels), 20.0);
  for (auto& evidence : profiles.evidence) evidence = {0.0, 0.0};
  const std::size_t count = chain.nodes.size();
  const ChainFit fit =
      fit_chain(chain, profiles, {std::vector<double>(count, 0.0), std::vector<double>(count, 4.0)}, {}, options);
  EXPECT_TRUE(fit.solve.converged);
  EXPECT_THAT(fit.shape.offset_m, testing::Each(testing::AllOf(testing::Gt(-1.7), testing::Lt(1.7))));
}

TEST(FitChain, stays_within_its_bounds) {
  StraightScene s(-3.0);
  s.options.search_radius_m = 1.0;
  const ChainFit fit = fit_chain(s.chain, s.profiles, s.start(5.0), {}, s.options);
  EXPECT_THAT(fit.shape.offset_m, testing::Each(testing::AllOf(testing::Ge(-1.0), testing::Le(1.0))));
  EXPECT_THAT(fit.shape.width_m, testing::Each(testing::AllOf(testing::Ge(3.0), testing::Le(10.8))));
}

TEST(FitChain, passes_through_its_meetings_and_keeps_to_its_limits) {
  const StraightScene s(0.0);
  ChainCoupling coupling;
  coupling.meetings = {{.node = 40, .offset_m = 0.5, .sigma_m = 0.01}};
  EXPECT_NEAR(s.fit(coupling).shape.offset_m[40], 0.5, 0.05);
  EXPECT_NEAR(s.fit().shape.offset_m[40], 0.0, 0.1);
  coupling = {};
  for (std::size_t i = 0; i < s.chain.nodes.size(); ++i) coupling.limits.push_back({i, 1.0, 2.4});
  const ChainFit limited = s.fit(coupling), free = s.fit();
  const auto left_edge = [](const ChainFit& fit) { return fit.shape.offset_m[40] + 0.5 * fit.shape.width_m[40]; };
  EXPECT_NEAR(left_edge(free), 3.0, 0.15);
  EXPECT_LT(left_edge(limited), 2.7) << "the limit pulls against the labels";
}

TEST(FitChain, nothing_seen_leaves_the_map) {
  StraightScene s(0.0);
  s.profiles.evidence.assign(s.profiles.evidence.size(), {0.0, 0.0});
  const ChainFit fit = s.fit();
  EXPECT_THAT(fit.shape.offset_m, testing::Each(testing::DoubleNear(0.0, 1e-6)));
  EXPECT_THAT(fit.shape.width_m, testing::Each(testing::DoubleNear(6.0, 1e-6)));
  ChainCoupling shifted;
  shifted.expected.assign(s.chain.nodes.size(), {1.2, 0.3});
  EXPECT_THAT(s.fit(shifted).shape.offset_m, testing::Each(testing::DoubleNear(1.2, 0.02))) << "the map's shift";
}

TEST(FitChain, a_closed_chain_ends_as_it_begins) {
  RoadScene scene = make_scene(200.0);
  const auto circle = [](double radius_m) {
    return trace(2.0 * M_PI * radius_m, [=](double s) {
      return at(100.0 + radius_m * std::cos(s / radius_m), 100.0 + radius_m * std::sin(s / radius_m));
    });
  };
  add_truth(scene, circle(40.0), 6.0);
  std::vector<RoadNode> nodes;
  for (int k = 0; k <= 48; ++k)  // drawn half a metre too far inside
    nodes.push_back(
        {.p = at(100.0 + 39.5 * std::cos(k % 48 * M_PI / 24.0), 100.0 + 39.5 * std::sin(k % 48 * M_PI / 24.0)),
         .width_m = 6.0});
  nodes.front().osm_node = nodes.back().osm_node = 7;
  add_way(scene, 1, nodes);
  const RefineRoadsOptions options;
  const RoadChain chain = build_chains(scene.osm, {.spacing_m = options.spacing_m}).at(0);
  ASSERT_TRUE(chain.closed);
  const CrossProfiles profiles = sample_cross_profiles(chain, road_evidence(scene.labels), 20.0);
  const std::vector<double> zero(chain.nodes.size(), 0.0), wide(chain.nodes.size(), 6.0);
  const ChainFit fit = fit_chain(chain, profiles, {zero, wide}, {}, options);
  EXPECT_EQ(fit.shape.offset_m.front(), fit.shape.offset_m.back());
  EXPECT_EQ(fit.shape.width_m.front(), fit.shape.width_m.back());
  EXPECT_EQ(fit.sigma_offset_m.front(), fit.sigma_offset_m.back());
  EXPECT_THAT(fit.shape.offset_m, testing::Each(testing::DoubleNear(-0.5, 0.2))) << "left of the way is inside";
}

TEST(CrossProfiles, show_the_road_where_it_is_painted) {
  const StraightScene s(1.0);  // the map lies to the left of the road: the road at t = -4 .. 2
  const std::size_t row = s.profiles.evidence.size() / 2;
  ASSERT_TRUE(s.profiles.road_near[row]);
  EXPECT_EQ(s.profiles.evidence[row].both(), 1.0);
  for (int k = 0; k < s.profiles.cells; ++k) {
    const double t = (k + 0.5) * s.profiles.step_m - s.profiles.half_m;
    const double outside = s.profiles.positive_row(row)[static_cast<std::size_t>(k)],
                 inside = s.profiles.negative_row(row)[static_cast<std::size_t>(k)];
    if (std::abs(t + 1.0) < 2.4) {
      EXPECT_TRUE(outside > 0.9 && inside < 0.1) << t;
    }
    if (std::abs(t + 1.0) > 3.6) {
      EXPECT_TRUE(outside < 0.1 && inside > 0.5) << t;
    }
  }
}

TEST(CrossProfiles, a_row_without_road_is_no_evidence) {
  StraightScene s(0.0);
  std::fill(s.profiles.false_positive.begin(), s.profiles.false_positive.begin() + s.profiles.cells, 0.0F);
  s.profiles.look_again(0);
  EXPECT_FALSE(s.profiles.road_near[0]);
  EXPECT_EQ(s.profiles.evidence[0].mean(), 0.0);
  EXPECT_GT(s.profiles.chain_evidence[0].both(), 0.0);
}

TEST(StripCosts, are_least_at_the_edges_and_have_their_derivatives) {
  const StraightScene s(0.0);
  const StripCosts strips(s.profiles, 1.5);
  using enum StripCosts::Edge;
  using Strip = StripCosts::Value StripCosts::Values::*;
  const Strip context = &StripCosts::Values::context, boundary = &StripCosts::Values::boundary;
  const std::size_t row = 80;
  for (const auto edge : {left, right})
    for (const Strip strip : {context, boundary})
      for (double t = -6.0; t < 6.0; t += 0.173) {
        const auto value = [&](double at) { return strips.at(edge, row, at).*strip; };
        const double h = 1e-6;
        const double slope = (value(t + h).cost - value(t - h).cost) / (2.0 * h);
        EXPECT_NEAR(value(t).derivative, slope, 1e-5) << t;
      }
  EXPECT_NEAR(strips.at(left, row, 3.0).context.cost, 0.0, 0.15) << "no road to the left of the left edge";
  EXPECT_NEAR(strips.at(left, row, 3.0).boundary.cost, 0.0, 0.15);
  EXPECT_GT(strips.at(left, row, 1.0).context.cost, 0.7) << "an edge inside the road leaves road outside";
  EXPECT_GT(strips.at(left, row, 5.0).boundary.cost, 0.4) << "an edge outside takes grass for road";
}

}  // namespace
}  // namespace orthodrive::refine
