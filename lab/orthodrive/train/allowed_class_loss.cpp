// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/allowed_class_loss.hpp"

#include <ATen/core/grad_mode.h>
namespace orthodrive {
namespace {

constexpr double least_log = -1e30;
constexpr double least_share = 1e-3;  // of the known pixels: a class below it has no IoU worth learning from

/// N x H x W of class sets -> N x C x H x W, bool.
at::Tensor allowed_mask(const at::Tensor& allowed, std::int64_t classes) {
  const at::Tensor sets = allowed.unsqueeze(1);
  const at::Tensor bits = at::arange(classes, sets.options()).view({1, classes, 1, 1});
  return at::bitwise_and(at::bitwise_right_shift(sets, bits), 1).to(at::kBool);
}

/// Which classes each pixel may have, and how much it counts.
struct Targets {
  at::Tensor mask;     ///< N x C x H x W, bool
  at::Tensor weights;  ///< N x 1 x H x W, already divided by their sum unless the loss is a sum
};

Targets make_targets(const at::Tensor& allowed, std::int64_t classes, const AllowedLossOptions& options) {
  Targets targets{allowed_mask(allowed, classes), {}};
  const at::Tensor count = targets.mask.sum(1, true);
  const at::Tensor by_class = at::tensor(options.class_weights).to(allowed.device());
  const at::Tensor single =
      by_class.index_select(0, targets.mask.to(at::kByte).argmax(1, true).flatten()).view_as(count);
  targets.weights = at::where(count == 1, single, at::full_like(single, options.set_weight));
  targets.weights.masked_fill_(count == 0, 0.0);
  if (!options.sum) targets.weights /= targets.weights.sum().clamp_min(1e-30);
  return targets;
}

}  // namespace

LossGradient allowed_class_loss(const at::Tensor& scores, const at::Tensor& allowed,
                                const AllowedLossOptions& options) {
  const at::NoGradGuard no_grad;
  const Targets targets = make_targets(allowed, scores.size(1), options);
  const at::Tensor log_p = at::log_softmax(scores, 1);
  const at::Tensor log_allowed = log_p.masked_fill(targets.mask.logical_not(), least_log);
  const at::Tensor log_inside = at::logsumexp(log_allowed, 1, true);
  const at::Tensor counted = targets.weights > 0.0;
  const double loss =
      -(at::where(counted, log_inside, at::zeros_like(log_inside)) * targets.weights).sum().item<double>();
  // d(-log sum) / d score c = p(c) - p(c | allowed)
  at::Tensor gradient = (log_p.exp() - (log_allowed - log_inside).exp()) * targets.weights;
  gradient.masked_fill_(counted.logical_not(), 0.0);
  return {loss, gradient};
}

LossGradient expected_error(const at::Tensor& marginals, const at::Tensor& allowed, const AllowedLossOptions& options) {
  const at::NoGradGuard no_grad;
  const Targets targets = make_targets(allowed, marginals.size(1), options);
  const at::Tensor inside = (marginals * targets.mask).sum(1, true);
  const double loss = ((1.0 - inside) * targets.weights).sum().item<double>();
  return {loss, targets.mask * (-targets.weights)};
}

LossGradient jaccard_loss(const at::Tensor& scores, const at::Tensor& allowed) {
  const at::NoGradGuard no_grad;
  const at::Tensor p = at::softmax(scores, 1), mask = allowed_mask(allowed, scores.size(1));
  const at::Tensor count = mask.sum(1, true);
  const at::Tensor truth = mask.logical_and(count == 1).to(p.dtype());
  const at::Tensor rest = mask.logical_not().logical_and(count > 0).to(p.dtype());
  const auto by_class = [](const at::Tensor& values) { return values.sum({0, 2, 3}, true, at::kDouble); };
  const at::Tensor size = by_class(truth);
  const at::Tensor present = (size > least_share * (count > 0).sum()).to(at::kDouble);
  const at::Tensor intersection = by_class(p * truth), joined = (size + by_class(p * rest)).clamp_min(1e-30);
  const at::Tensor share = present / present.sum().clamp_min(1.0);
  const double loss = (share * (1.0 - intersection / joined)).sum().item<double>();
  // d(-I / U) / d p: -1 / U on the truth, I / U^2 on the rest; then through the softmax
  const at::Tensor d_p =
      rest * (share * intersection / joined.square()).to(p.dtype()) - truth * (share / joined).to(p.dtype());
  return {loss, p * (d_p - (p * d_p).sum(1, true))};
}

}  // namespace orthodrive
