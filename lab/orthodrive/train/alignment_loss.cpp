// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/alignment_loss.hpp"

#include <ATen/core/grad_mode.h>

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

/// -log p of an error under a Laplace distribution of that log scale, but for log 2, and its derivatives.
struct Likelihood {
  double loss, d_error, d_log_scale;
};
Likelihood laplace(double error, double log_scale) {
  const double clamped = std::clamp(log_scale, least_log_scale, most_log_scale), weight = std::exp(-clamped),
               size = std::abs(error) * weight;
  // Beyond the clamp the scale is still drawn back.
  const double slope = log_scale == clamped ? 1.0 - size : log_scale - clamped;
  return {size + clamped, std::copysign(weight, error), slope};
}

}  // namespace

LossGradient alignment_loss(const at::Tensor& outputs, std::span<const AlignmentTruth> truth) {
  const at::NoGradGuard no_grad;
  const at::Tensor values = outputs.detach().to(at::kCPU).permute({0, 2, 3, 1}).contiguous();
  at::Tensor gradient = at::zeros_like(values);
  const float* v = values.data_ptr<float>();
  float* g = gradient.data_ptr<float>();
  const auto known = static_cast<double>(std::ranges::count_if(truth, &AlignmentTruth::known));
  double loss = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i, v += alignment_channels, g += alignment_channels) {
    const AlignmentTruth& t = truth[i];
    if (!t.known) continue;
    const double said = v[0] * t.normal_x + v[1] * t.normal_y;
    const Likelihood offset = laplace(said - t.offset / alignment_unit_px, v[2]),
                     width = laplace(v[3] - t.half_width / alignment_unit_px, v[4]);
    loss += (offset.loss + width.loss) / known;
    g[0] = static_cast<float>(offset.d_error * t.normal_x / known);
    g[1] = static_cast<float>(offset.d_error * t.normal_y / known);
    g[2] = static_cast<float>(offset.d_log_scale / known);
    g[3] = static_cast<float>(width.d_error / known);
    g[4] = static_cast<float>(width.d_log_scale / known);
  }
  return {loss, gradient.permute({0, 3, 1, 2}).to(outputs.device())};
}

}  // namespace orthodrive
