// SPDX-License-Identifier: Apache-2.0
// The search itself, on losses whose best weights are known.

#include "orthodrive/refine/search_weights.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/refine/weight_table.hpp"

namespace orthodrive {
namespace {

const std::vector<std::string> two_folds{"a", "a", "b", "b"};

/// How many factors of e two of the weights are away from these, and a little of all others from the shipped ones.
double away_from(double angle, double width, const RefineWeights& weights) {
  double away = std::abs(std::log(weights.angle / angle)) + std::abs(std::log(weights.width / width));
  const RefineWeights shipped;
  for (const NamedWeight& weight : refine_weight_table())
    away += 0.01 * std::abs(std::log(weights.*weight.value / (shipped.*weight.value)));
  return away;
}
double agreed(const RefineWeights& weights, std::size_t) { return away_from(80.0, 10.0, weights); }
/// What helps sites of fold a harms those of fold b.
double opposed(const RefineWeights& weights, std::size_t site) {
  return site < 2 ? away_from(80.0, 10.0, weights) : away_from(5.0, 160.0, weights);
}

std::vector<double> values(const RefineWeights& weights) {
  std::vector<double> values;
  for (const NamedWeight& weight : refine_weight_table()) values.push_back(weights.*weight.value);
  return values;
}

TEST(WeightTable, each_entry_is_another_member_under_another_name) {
  RefineWeights weights;
  std::set<std::string_view> names;
  double number = 1.0;
  for (const NamedWeight& weight : refine_weight_table()) weights.*weight.value = number++, names.insert(weight.name);
  EXPECT_EQ(names.size(), refine_weight_table().size());
  number = 1.0;
  for (const double value : values(weights)) EXPECT_EQ(value, number++);
  EXPECT_EQ(weights.evidence, 1.0) << "in the order of the declaration";
  EXPECT_EQ(weights.search_width_share, static_cast<double>(refine_weight_table().size()));
}

TEST(SearchWeights, where_sites_agree_the_gain_is_there_on_held_out_ones) {
  const WeightSearch search = search_weights(two_folds, agreed, {.trials = 150});
  ASSERT_EQ(search.folds.size(), 2u);
  EXPECT_EQ(search.folds[0].held_out_fold, "a");
  EXPECT_THAT(search.folds[0].held_out.sites, testing::ElementsAre(0, 1));
  EXPECT_THAT(search.folds[0].training.sites, testing::ElementsAre(2, 3));
  EXPECT_THAT(search.all.training.sites, testing::ElementsAre(0, 1, 2, 3));
  EXPECT_TRUE(search.all.held_out.sites.empty());
  EXPECT_NEAR(search.all.training.start_m, away_from(80.0, 10.0, {}), 1e-12);
  EXPECT_LT(search.all.training.tuned_m, 0.3 * search.all.training.start_m);
  EXPECT_GT(search.held_out_gain_m(), 1.5);
  EXPECT_NEAR(search.overfitting_m(), 0.0, 1e-12);
  EXPECT_EQ(search.all.training.tuned_m, agreed(search.all.weights, 0)) << "the loss is that of the weights handed out";
}

TEST(SearchWeights, a_gain_that_held_out_sites_lose_is_over_fitting) {
  const WeightSearch search = search_weights(two_folds, opposed, {.trials = 150});
  EXPECT_GT(search.training_gain_m(), 1.5);
  EXPECT_LT(search.held_out_gain_m(), -1.0);
  EXPECT_EQ(search.overfitting_m(), search.training_gain_m() - search.held_out_gain_m());
}

TEST(SearchWeights, held_out_sites_are_not_looked_at) {
  // Other losses on the sites of fold b: what is tuned without b must not notice, what is tuned on b must.
  const auto other = [](const RefineWeights& weights, std::size_t site) {
    return site < 2 ? opposed(weights, site) : away_from(40.0, 20.0, weights);
  };
  const WeightSearch one = search_weights(two_folds, opposed), two = search_weights(two_folds, other);
  EXPECT_EQ(values(one.folds[1].weights), values(two.folds[1].weights));
  EXPECT_EQ(one.folds[1].training.tuned_m, two.folds[1].training.tuned_m);
  EXPECT_NE(one.folds[1].held_out.tuned_m, two.folds[1].held_out.tuned_m);
  EXPECT_NE(values(one.folds[0].weights), values(two.folds[0].weights));
  EXPECT_NE(values(one.all.weights), values(two.all.weights));
}

TEST(SearchWeights, threads_change_nothing_but_the_seed_does) {
  const WeightSearch one = search_weights(two_folds, opposed, {.trials = 40, .threads = 1}),
                     four = search_weights(two_folds, opposed, {.trials = 40, .threads = 4}),
                     seeded = search_weights(two_folds, opposed, {.trials = 40, .seed = 2});
  for (std::size_t fold = 0; fold < 2; ++fold)
    EXPECT_EQ(values(one.folds[fold].weights), values(four.folds[fold].weights));
  EXPECT_EQ(values(one.all.weights), values(four.all.weights));
  EXPECT_EQ(one.evaluations, four.evaluations);
  EXPECT_NE(values(one.folds[0].weights), values(seeded.folds[0].weights));
}

TEST(SearchWeights, what_cannot_gain_stays_and_folds_share_their_trials) {
  const auto flat = [](const RefineWeights&, std::size_t) { return 1.0; };
  const auto lost = [](const RefineWeights& weights, std::size_t site) {
    return values(weights) == values(RefineWeights{}) ? 1.0 + static_cast<double>(site)
                                                      : std::numeric_limits<double>::quiet_NaN();
  };
  for (const WeightLoss& loss : {WeightLoss(flat), WeightLoss(lost)}) {
    const WeightSearch search = search_weights(two_folds, loss, {.trials = 10});
    EXPECT_EQ(search.all.accepted, 0);
    EXPECT_EQ(values(search.all.weights), values(RefineWeights{}));
    EXPECT_EQ(search.held_out_gain_m(), 0.0);
    EXPECT_EQ(search.evaluations, 4u * (1u + 10u)) << "three searches draw the same trials: each is evaluated once";
  }
}

TEST(SearchWeights, needs_two_folds_and_a_loss_to_start_with) {
  const std::vector<std::string> one_fold{"a", "a"}, no_name{"a", ""};
  EXPECT_THROW((void)search_weights(one_fold, agreed), OptionError);
  EXPECT_THROW((void)search_weights({}, agreed), OptionError);
  EXPECT_THROW((void)search_weights(no_name, agreed), OptionError);
  EXPECT_THROW((void)search_weights(two_folds, agreed, {.trials = -1}), OptionError);
  const auto nothing = [](const RefineWeights&, std::size_t site) {
    return site == 3 ? std::numeric_limits<double>::quiet_NaN() : 1.0;
  };
  EXPECT_THROW((void)search_weights(two_folds, nothing), OptionError);
}

}  // namespace
}  // namespace orthodrive
