// SPDX-License-Identifier: Apache-2.0
#pragma once
// forward_padded() in two parts, for learning that leaves the first layers as they are. Includes ATen: for .cpp files.

#include <ATen/ATen.h>

#include <vector>

#include "orthodrive/train/padded_network.hpp"

namespace orthodrive {

/// What comes out of the layers before `first`, where later ones read it; undefined tensors elsewhere. Batch norm runs
/// as in prediction.
[[nodiscard]] std::vector<at::Tensor> forward_padded_before(const NetworkGraph& graph, NetworkParams& params,
                                                            const InputTensors& input, std::size_t first);
/// The scores that come of it, for an image of that edge.
[[nodiscard]] Scores forward_padded_from(const NetworkGraph& graph, NetworkParams& params,
                                         std::vector<at::Tensor> before, std::size_t first, int image_size_px);

}  // namespace orthodrive
