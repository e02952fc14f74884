// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/allowed_class_loss.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/allowed_classes.hpp"

namespace orthodrive {
namespace {

constexpr std::int64_t classes = 5;

at::Tensor random_scores(std::int64_t pixels, std::uint64_t seed) {
  Random random(seed);
  at::Tensor scores = at::empty({1, classes, 1, pixels});
  for (std::int64_t i = 0; i < scores.numel(); ++i)
    scores.data_ptr<float>()[i] = static_cast<float>(2.0 * random.normal());
  return scores;
}

at::Tensor sets(const std::vector<std::int64_t>& allowed) {
  return at::tensor(allowed).view({1, 1, static_cast<std::int64_t>(allowed.size())});
}

std::int64_t single(int label) { return static_cast<std::int64_t>(only(label)); }

TEST(AllowedClassLoss, single_classes_give_weighted_cross_entropy) {
  const at::Tensor scores = random_scores(4, 1);
  const std::vector<float> weights{1.0F, 2.0F, 0.5F, 1.0F, 3.0F};
  const std::vector<int> labels{1, 0, 4, 2};
  double expected = 0.0, total = 0.0;
  std::vector<std::int64_t> allowed;
  for (std::int64_t i = 0; i < 4; ++i) {
    const int label = labels[static_cast<std::size_t>(i)];
    const float weight = weights[static_cast<std::size_t>(label)];
    double sum = 0.0;
    for (std::int64_t c = 0; c < classes; ++c) sum += std::exp(scores[0][c][0][i].item<double>());
    expected += weight * (std::log(sum) - scores[0][label][0][i].item<double>());
    total += weight;
    allowed.push_back(single(label));
  }
  EXPECT_NEAR(allowed_class_loss(scores, sets(allowed), {weights}).loss, expected / total, 1e-6);
  EXPECT_NEAR(allowed_class_loss(scores, sets(allowed), {weights, 1.0F, true}).loss, expected, 1e-5);
  const at::Tensor p = at::softmax(scores, 1);
  double wrong = 0.0;
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    const auto label = static_cast<std::int64_t>(std::countr_zero(static_cast<std::uint64_t>(allowed[i])));
    wrong +=
        weights[static_cast<std::size_t>(label)] * (1.0 - p[0][label][0][static_cast<std::int64_t>(i)].item<double>());
  }
  EXPECT_NEAR(expected_error(p, sets(allowed), {weights}).loss, wrong / total, 1e-6);
}

TEST(AllowedClassLoss, everything_allowed_costs_nothing_and_unknown_does_not_count) {
  const at::Tensor scores = random_scores(3, 2);
  const std::vector<float> weights(classes, 1.0F);
  const std::int64_t all = (1 << classes) - 1;
  EXPECT_NEAR(allowed_class_loss(scores, sets({all, all, all}), {weights}).loss, 0.0, 1e-6);
  const LossGradient nothing = allowed_class_loss(scores, sets({0, 0, 0}), {weights});
  EXPECT_EQ(nothing.loss, 0.0);
  EXPECT_EQ(nothing.gradient.abs().max().item<float>(), 0.0F);
  const double one = allowed_class_loss(scores.narrow(3, 0, 1), sets({single(2)}), {weights}).loss;
  EXPECT_NEAR(allowed_class_loss(scores, sets({single(2), 0, 0}), {weights}).loss, one, 1e-6);
}

TEST(AllowedClassLoss, gradients_are_the_derivatives) {
  const at::Tensor scores = random_scores(6, 3);
  const at::Tensor allowed = sets({single(0), 0b01010, 0b10011, 0, single(4), 0b11110});
  const AllowedLossOptions options{{1.0F, 2.0F, 0.5F, 1.0F, 3.0F}, 0.7F};
  const at::Tensor gradient = allowed_class_loss(scores, allowed, options).gradient;
  at::Tensor probabilities = at::softmax(scores, 1).contiguous();
  const at::Tensor of_probabilities = expected_error(probabilities, allowed, options).gradient.contiguous();
  const auto slope = [](const at::Tensor& x, std::int64_t i, float step, const auto& loss) {
    float* value = x.data_ptr<float>() + i;
    const float before = *value;
    *value = before + step;
    const double above = loss();
    *value = before - step;
    const double below = loss();
    *value = before;
    return (above - below) / (2.0 * step);
  };
  for (std::int64_t i = 0; i < scores.numel(); ++i) {
    EXPECT_NEAR(gradient.flatten()[i].item<double>(),
                slope(scores, i, 1e-2F, [&] { return allowed_class_loss(scores, allowed, options).loss; }), 3e-5);
    const double p = probabilities.flatten()[i].item<double>(), expected = of_probabilities.flatten()[i].item<double>();
    const double measured = slope(probabilities, i, static_cast<float>(1e-2 * p),
                                  [&] { return expected_error(probabilities, allowed, options).loss; });
    EXPECT_NEAR(expected * p, measured * p, 3e-5);
  }
}

TEST(JaccardLoss, is_one_minus_the_mean_soft_iou_and_its_gradient_the_derivative) {
  const at::Tensor scores = random_scores(6, 5), allowed = sets({single(0), single(0), single(3), 0b01010, 0b00110, 0});
  const at::Tensor p = at::softmax(scores, 1);
  const auto of = [&](std::int64_t c, std::int64_t i) { return p[0][c][0][i].item<double>(); };
  // Class 0: pixels 0 and 1; the others are known not to be it, but for the unknown one. Class 3: pixel 2; pixel 3 may
  // be.
  const double iou0 = (of(0, 0) + of(0, 1)) / (2.0 + of(0, 2) + of(0, 3) + of(0, 4));
  const double iou3 = of(3, 2) / (1.0 + of(3, 0) + of(3, 1) + of(3, 4));
  const LossGradient result = jaccard_loss(scores, allowed);
  EXPECT_NEAR(result.loss, 1.0 - 0.5 * (iou0 + iou3), 1e-6);
  for (std::int64_t i = 0; i < scores.numel(); ++i) {
    at::Tensor above = scores.clone(), below = scores.clone();
    above.data_ptr<float>()[i] += 1e-2F;
    below.data_ptr<float>()[i] -= 1e-2F;
    const double slope = (jaccard_loss(above, allowed).loss - jaccard_loss(below, allowed).loss) / 2e-2;
    EXPECT_NEAR(result.gradient.flatten()[i].item<double>(), slope, 3e-5);
  }
}

TEST(JaccardLoss, is_nought_for_sure_and_right_scores_and_for_sets_alone) {
  const at::Tensor sure =
      50.0 * at::one_hot(at::tensor({0, 3, 1}, at::kLong), classes).t().reshape({1, classes, 1, 3}).to(at::kFloat);
  EXPECT_NEAR(jaccard_loss(sure, sets({single(0), single(3), single(1)})).loss, 0.0, 1e-6);
  const LossGradient nothing = jaccard_loss(random_scores(2, 6), sets({0b11000, 0}));
  EXPECT_EQ(nothing.loss, 0.0);
  EXPECT_EQ(nothing.gradient.abs().max().item<float>(), 0.0F);
}

TEST(AllowedClassLoss, scores_far_apart_stay_finite) {
  const at::Tensor scores = at::tensor({1000.0F, -1000.0F, 0.0F, 0.0F, 0.0F}).view({1, classes, 1, 1});
  const LossGradient result = allowed_class_loss(scores, sets({single(1)}), {std::vector<float>(classes, 1.0F)});
  EXPECT_NEAR(result.loss, 2000.0, 1.0);
  EXPECT_NEAR(result.gradient.flatten()[0].item<double>(), 1.0, 1e-6);
  EXPECT_NEAR(result.gradient.flatten()[1].item<double>(), -1.0, 1e-6);
}

}  // namespace
}  // namespace orthodrive
