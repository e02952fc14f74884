// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/search_crf.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"

namespace orthodrive {
namespace {

constexpr int size = 48, crf_classes = 3;

/// Three bands of clear colours; the network is right in `sure` of its pixels.
CrfSample bands(double sure, std::uint64_t seed) {
  CrfSample sample{Raster<std::uint8_t>(size, size, 3), Raster<ClassSet>(size, size), {}};
  Random random(seed);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col) {
      const int truth = col / 16;
      for (int c = 0; c < 3; ++c)
        sample.rgb.at(col, row, c) = static_cast<std::uint8_t>((c == truth ? 190 : 60) + 10.0 * random.uniform());
      sample.allowed.at(col, row) = only(truth);
      const int said = random.uniform() < sure ? truth : (truth + 1) % crf_classes;
      for (int c = 0; c < crf_classes; ++c) sample.unary.push_back(c == said ? 0.4F : 1.8F);
    }
  return sample;
}

double merit(const CrfTrial& t) { return 0.5 * (t.pixel_accuracy + t.mean_iou); }

TEST(SearchCrf, takes_the_cheapest_that_keeps_most_of_the_gain) {
  const std::vector<CrfSample> samples{bands(0.75, 1), bands(0.75, 2)};
  const CrfSearchOptions options;
  const CrfSearch search = search_crf(samples, crf_classes, options);
  const CrfTrial none = search.trials.front();
  EXPECT_EQ(none.appearance_weight, 0.0F);
  double best = 0.0, best_appearance = 0.0;
  for (const CrfTrial& t : search.trials) {
    best = std::max(best, merit(t));
    if (t.smoothness_weight == 0.0F && t.iterations == options.iterations)
      best_appearance = std::max(best_appearance, merit(t));
  }
  EXPECT_GT(best, merit(none) + 0.1) << "a CRF mends three quarters of right pixels";
  const auto chosen = std::ranges::find_if(search.trials, [&](const CrfTrial& t) {
    return t.widths.theta_alpha_px == search.best.widths.theta_alpha_px &&
           t.widths.theta_beta == search.best.widths.theta_beta && t.smoothness_weight == 0.0F &&
           t.appearance_weight == search.best.parameters.appearance_weight.front();
  });
  ASSERT_NE(chosen, search.trials.end());
  const double enough = best_appearance - tolerated_loss * (best_appearance - merit(none));
  EXPECT_GE(merit(*chosen), enough);
  for (const CrfTrial& t : search.trials)
    if (t.appearance_weight > 0.0F && t.smoothness_weight == 0.0F && merit(t) >= enough &&
        t.iterations == options.iterations) {
      EXPECT_GE(t.vertices_per_pixel, chosen->vertices_per_pixel);
    }
  EXPECT_LE(search.best.parameters.iterations, options.iterations);
  EXPECT_GE(search.best.parameters.iterations, 3);
}

TEST(SearchCrf, tells_what_ends_at_the_edge_of_the_grid) {
  const std::vector<CrfSample> samples{bands(0.75, 1), bands(0.75, 2)};
  CrfSearchOptions options{.theta_alpha_px = {9.0}, .theta_beta = {11.0}, .appearance_weight = {0.01F, 0.02F, 2.0F}};
  options.theta_gamma_px = {1.0}, options.smoothness_weight = {0.5F}, options.fewer_iterations = {};
  const CrfSearch search = search_crf(samples, crf_classes, options);
  EXPECT_EQ(search.at_edges, std::vector<std::string>{"appearance_weight = 2 of 0.01 to 2"}) << "one value has no edge";
  EXPECT_EQ(search.trials.size(), 5U);
}

TEST(SearchCrf, leaves_a_perfect_network_alone) {
  const CrfSearch search = search_crf(std::vector{bands(1.1, 1)}, crf_classes, {});
  EXPECT_EQ(search.trials.front().mean_iou, 1.0);
  EXPECT_EQ(search.best.parameters.appearance_weight.front(), 0.0F);
  EXPECT_TRUE(search.at_edges.empty());
}

}  // namespace
}  // namespace orthodrive
