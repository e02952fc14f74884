// SPDX-License-Identifier: Apache-2.0
#pragma once
// How well a network says where the roads of a map truly lie. Includes ATen: for the .cpp files of this folder only.

#include <ATen/ATen.h>

#include <span>

#include "orthodrive/train/allowed_class_loss.hpp"
#include "orthodrive/train/disturbed_map.hpp"

namespace orthodrive {

/// Mean negative log-likelihood (Laplace) of the offset across the line, plus that of half the width, over the pixels
/// that know them; no pixel knows any: 0. `outputs`: N x alignment_channels x H x W (map_alignment.hpp); `truth`: N x H
/// x W, of the same pixels. Kendall and Gal, What uncertainties do we need in Bayesian deep learning, 2017, eq. 8.
[[nodiscard]] LossGradient alignment_loss(const at::Tensor& outputs, std::span<const AlignmentTruth> truth);

}  // namespace orthodrive
