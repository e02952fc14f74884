// SPDX-License-Identifier: Apache-2.0
#pragma once
// The layers of a network one by one, as prediction computes them: no padding, all cells of the input are there.

#include <vector>

#include "orthodrive/nets/packed_convolution.hpp"

namespace orthodrive {

/// What a layer computes with. `matrices`: one of a convolution; of a deconvolution stride x stride, one for each
/// position of an output cell within a stride (row by row), as convolutions of the input.
struct PlainLayer {
  std::vector<PackedConvolution> matrices;
  std::vector<float> depthwise_weights, depthwise_bias;  ///< filled up to whole vectors
};
[[nodiscard]] PlainLayer make_plain_layer(const Layer& layer, const LayerWeights& weights);

/// Writes the cells that `output` names. `inputs` must hold input_range() of them.
void run_plain(const Layer& layer, const PlainLayer& made, const std::vector<CellView>& inputs, const Cells& output);

}  // namespace orthodrive
