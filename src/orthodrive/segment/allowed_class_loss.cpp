#include "orthodrive/segment/allowed_class_loss.hpp"

namespace orthodrive {
namespace {

constexpr double least_log = -1e30;

/// Which classes each pixel may have, and how much it counts.
struct Targets {
  at::Tensor mask;     ///< N x C x H x W, bool
  at::Tensor weights;  ///< N x 1 x H x W, already divided by their sum unless the loss is a sum
};

Targets make_targets(const at::Tensor& allowed, std::int64_t classes, const AllowedLossOptions& options) {
  const at::Tensor sets = allowed.unsqueeze(1);
  const at::Tensor bits = at::arange(classes, sets.options()).view({1, classes, 1, 1});
  Targets targets{at::bitwise_and(at::bitwise_right_shift(sets, bits), 1).to(at::kBool), {}};
  const at::Tensor count = targets.mask.sum(1, true);
  const at::Tensor by_class = at::tensor(options.class_weights).to(sets.device());
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

}  // namespace orthodrive
