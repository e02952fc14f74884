#include "orthodrive/segment/allowed_classes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

constexpr std::size_t classes = 5;

std::vector<float> random_scores(std::size_t pixels, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> scores(pixels * classes);
  for (float& s : scores) s = static_cast<float>(2.0 * random.normal());
  return scores;
}

double loss_of(const std::vector<float>& scores, const std::vector<ClassSet>& allowed,
               const AllowedLossOptions& options) {
  std::vector<float> gradient(scores.size());
  return allowed_class_loss(scores, allowed, options, gradient);
}

TEST(AllowedClassLoss, single_classes_give_weighted_cross_entropy) {
  const std::vector<float> scores = random_scores(4, 1), weights{1.0F, 2.0F, 0.5F, 1.0F, 3.0F};
  const std::vector<int> labels{1, 0, 4, 2};
  double expected = 0.0, total = 0.0;
  std::vector<ClassSet> allowed;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto label = static_cast<std::size_t>(labels[i]);
    double sum = 0.0;
    for (std::size_t c = 0; c < classes; ++c) sum += std::exp(static_cast<double>(scores[i * classes + c]));
    expected += weights[label] * (std::log(sum) - scores[i * classes + label]);
    total += weights[label];
    allowed.push_back(only(labels[i]));
  }
  EXPECT_NEAR(loss_of(scores, allowed, {weights}), expected / total, 1e-6);
}

TEST(AllowedClassLoss, everything_allowed_costs_nothing_and_unknown_does_not_count) {
  const std::vector<float> scores = random_scores(3, 2), weights(classes, 1.0F);
  const ClassSet all = (1 << classes) - 1;
  EXPECT_NEAR(loss_of(scores, {all, all, all}, {weights}), 0.0, 1e-6);
  EXPECT_EQ(loss_of(scores, {0, 0, 0}, {weights}), 0.0);
  const double one = loss_of({scores.begin(), scores.begin() + classes}, {only(2)}, {weights});
  EXPECT_NEAR(loss_of(scores, {only(2), 0, 0}, {weights}), one, 1e-7);
}

TEST(AllowedClassLoss, gradient_is_the_derivative) {
  std::vector<float> scores = random_scores(6, 3);
  const std::vector<ClassSet> allowed{only(0), 0b01010, 0b10011, 0, only(4), 0b11110};
  const AllowedLossOptions options{{1.0F, 2.0F, 0.5F, 1.0F, 3.0F}, 0.7F};
  std::vector<float> gradient(scores.size());
  static_cast<void>(allowed_class_loss(scores, allowed, options, gradient));
  constexpr float step = 1e-2F;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const float before = scores[i];
    scores[i] = before + step;
    const double above = loss_of(scores, allowed, options);
    scores[i] = before - step;
    const double below = loss_of(scores, allowed, options);
    scores[i] = before;
    EXPECT_NEAR(gradient[i], (above - below) / (2.0 * step), 2e-5) << i;
  }
}

TEST(AllowedClassLoss, scores_far_apart_stay_finite) {
  std::vector<float> gradient(classes);
  const std::vector<float> scores{1000.0F, -1000.0F, 0.0F, 0.0F, 0.0F};
  const std::vector<ClassSet> allowed{only(1)};
  const double loss = allowed_class_loss(scores, allowed, {std::vector<float>(classes, 1.0F)}, gradient);
  EXPECT_TRUE(std::isfinite(loss));
  EXPECT_GT(loss, 60.0);
  EXPECT_NEAR(gradient[0], 1.0, 1e-6);
}

TEST(LabelScore, counts_by_hand) {
  LabelScore score(3);
  //                 hit     miss 0, wrong 1   unknown  in the set  outside it: wrong 0   nodata
  const std::vector<std::uint8_t> labels{0, 1, 2, 1, 0, 255};
  const std::vector<ClassSet> allowed{only(0), only(0), 0, 0b110, 0b110, only(1)};
  score.add(labels, allowed);
  EXPECT_DOUBLE_EQ(score.iou(0), 1.0 / 3.0);  // 1 hit, 1 missed, 1 wrong
  EXPECT_TRUE(std::isnan(score.iou(1)));      // only predicted
  EXPECT_TRUE(std::isnan(score.iou(2)));
  EXPECT_DOUBLE_EQ(score.mean_iou(), 1.0 / 3.0);  // only class 0 is in the truth
  EXPECT_DOUBLE_EQ(score.pixel_accuracy(), 0.5);
}

}  // namespace
}  // namespace orthodrive
