// SPDX-License-Identifier: Apache-2.0
#pragma once
// Weights of a network's layers, ready for prediction.

#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/model/rasters/tensor_file.hpp"
#include "orthodrive/nets/network_graph.hpp"

namespace orthodrive {

constexpr double batch_norm_eps = 1e-3;  ///< of the Keras weights

/// Of one layer; empty where it has no weights.
struct LayerWeights {
  std::vector<float> kernel;  ///< kernel_file_shape(), row-major
  std::vector<float> bias;    ///< one value per output channel
};

/// H x W x I x O, of depthwise convolutions H x W x C x 1: the order in model files.
[[nodiscard]] std::vector<std::int64_t> kernel_file_shape(const Layer& layer);
[[nodiscard]] std::string bias_tensor(const Layer& layer);

/// The tensor of that name and shape. `source` names the file in messages. Throws InputError where it is missing or has
/// another shape.
[[nodiscard]] const NamedTensor& find_tensor(const NetworkGraph& graph, const TensorFile& file,
                                             const std::string& source, const std::string& name,
                                             const std::vector<std::int64_t>& shape);

/// One entry per layer of the graph, with batch norms folded into kernel and bias: the same scores with fewer passes
/// over memory. Throws as find_tensor().
[[nodiscard]] std::vector<LayerWeights> fold_batch_norm(const NetworkGraph& graph, const TensorFile& file,
                                                        const std::string& source);

}  // namespace orthodrive
