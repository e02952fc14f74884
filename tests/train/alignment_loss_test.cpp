// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/alignment_loss.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

std::vector<AlignmentTruth> some_truth() {
  std::vector<AlignmentTruth> truth(6);
  Random random(3);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double angle = random.uniform(0.0, 6.28);
    truth[i] = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)),
                static_cast<float>(random.uniform(-9.0, 9.0)), static_cast<float>(random.uniform(3.0, 9.0)), i != 4};
  }
  return truth;
}

TEST(AlignmentLoss, GradientIsThatOfFiniteDifferences) {
  const std::vector<AlignmentTruth> truth = some_truth();
  Random random(5);
  at::Tensor outputs = at::empty({1, alignment_channels, 2, 3});
  for (std::int64_t i = 0; i < outputs.numel(); ++i) outputs.data_ptr<float>()[i] = static_cast<float>(random.normal());
  const LossGradient at_start = alignment_loss(outputs, truth);
  for (std::int64_t i = 0; i < outputs.numel(); ++i) {
    constexpr float step = 1e-3F;
    at::Tensor more = outputs.clone(), less = outputs.clone();
    more.data_ptr<float>()[i] += step;
    less.data_ptr<float>()[i] -= step;
    const double slope = (alignment_loss(more, truth).loss - alignment_loss(less, truth).loss) / (2.0 * step);
    EXPECT_NEAR(at_start.gradient.contiguous().data_ptr<float>()[i], slope, 2e-3) << i;
  }
}

TEST(AlignmentLoss, IsLeastAtTheTruthAndAsksForDoubtWhereItIsWrong) {
  const std::vector<AlignmentTruth> truth{{1.0F, 0.0F, 8.0F, 4.0F, true}};
  const auto loss = [&](float x, float log_scale) {
    return alignment_loss(at::tensor({x, 3.0F, log_scale, 0.5F, -1.0F}).view({1, 5, 1, 1}), truth).loss;
  };
  EXPECT_LT(loss(1.0F, -2.0F), loss(1.0F, 0.0F));    // right: sure is better
  EXPECT_GT(loss(-1.0F, -2.0F), loss(-1.0F, 0.0F));  // wrong: doubt is better
  EXPECT_LT(loss(1.0F, -2.0F), loss(0.5F, -2.0F));
}

TEST(AlignmentLoss, OfNothingKnownIsNothing) {
  const std::vector<AlignmentTruth> truth(4);
  const LossGradient loss = alignment_loss(at::ones({1, alignment_channels, 2, 2}), truth);
  EXPECT_EQ(loss.loss, 0.0);
  EXPECT_EQ(loss.gradient.abs().max().item<double>(), 0.0);
}

}  // namespace
}  // namespace orthodrive
