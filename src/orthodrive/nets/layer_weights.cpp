// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/layer_weights.hpp"

#include <fmt/format.h>

#include <cmath>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

std::vector<std::int64_t> kernel_file_shape(const Layer& layer) {
  if (layer.depthwise) return {layer.kernel, layer.kernel, layer.in, 1};
  return {layer.kernel, layer.kernel, layer.in, layer.out};
}

std::string bias_tensor(const Layer& layer) {
  return layer.kernel_tensor.substr(0, layer.kernel_tensor.rfind('/')) + "/bias";
}

const NamedTensor& find_tensor(const NetworkGraph& graph, const TensorFile& file, const std::string& source,
                               const std::string& name, const std::vector<std::int64_t>& shape) {
  const auto it = file.tensors.find(name);
  if (it == file.tensors.end())
    throw InputError(source, fmt::format("tensor '{}' is missing, it is no {} model", name, graph.architecture));
  if (it->second.shape != shape)
    throw InputError(source, fmt::format("tensor '{}' has shape [{}], need [{}]", name,
                                         fmt::join(it->second.shape, ","), fmt::join(shape, ",")));
  return it->second;
}

std::vector<LayerWeights> fold_batch_norm(const NetworkGraph& graph, const TensorFile& file,
                                          const std::string& source) {
  std::vector<LayerWeights> weights;
  for (const Layer& layer : graph.layers) {
    LayerWeights& w = weights.emplace_back();
    if (layer.kernel_tensor.empty()) continue;
    const auto channels = static_cast<std::size_t>(layer.out);
    const auto vector_named = [&](const std::string& name) -> const std::vector<float>& {
      return find_tensor(graph, file, source, name, {layer.out}).values;
    };
    w.kernel = find_tensor(graph, file, source, layer.kernel_tensor, kernel_file_shape(layer)).values;
    if (layer.norm_tensors.empty()) {
      w.bias = vector_named(bias_tensor(layer));
      continue;
    }
    const std::vector<float>&gamma = vector_named(layer.norm_tensors + "/gamma"),
          &beta = vector_named(layer.norm_tensors + "/beta"), &mean = vector_named(layer.norm_tensors + "/moving_mean"),
          &variance = vector_named(layer.norm_tensors + "/moving_variance");
    w.bias.resize(channels);
    for (std::size_t c = 0; c < channels; ++c) {
      const float scale = gamma[c] / std::sqrt(variance[c] + static_cast<float>(batch_norm_eps));
      w.bias[c] = beta[c] - mean[c] * scale;
      for (std::size_t i = c; i < w.kernel.size(); i += channels) w.kernel[i] *= scale;  // channels are the last axis
    }
  }
  return weights;
}

}  // namespace orthodrive
