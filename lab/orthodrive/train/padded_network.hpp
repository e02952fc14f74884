// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs a NetworkGraph with libtorch, with derivatives and with the padding that training has. Includes ATen: for the
// .cpp files of this folder only.

#include <ATen/ATen.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "orthodrive/model/rasters/tensor_file.hpp"
#include "orthodrive/nets/inference_network.hpp"
#include "orthodrive/nets/network_graph.hpp"

namespace orthodrive {

/// Weights of one layer. Kernels O x I x H x W in channels-last (deconvolutions I x O x H x W); then either a batch
/// norm or a bias.
struct LayerParams {
  at::Tensor kernel, gamma, beta, mean, variance, bias;
};
using NetworkParams =
    std::vector<LayerParams>;  ///< one per layer of the graph, undefined tensors where it has no weights

struct TrainingMode {
  bool update_batch_statistics = false;  ///< batch norm uses and updates the batch's statistics
  bool dropout = false;                  ///< from torch's default generator
  bool of_map_only = false;              ///< update_batch_statistics of the layers of the map alone
};

/// What a network sees, N x channels x H x W each, channels-last.
struct InputTensors {
  at::Tensor photo;  ///< 3 channels
  at::Tensor map;    ///< map channels; undefined for networks that see none
  [[nodiscard]] InputTensors to(at::Device device) const;
};

/// Class scores for pixels of an image.
struct Scores {
  at::Tensor values;         ///< N x C x rows x cols
  CellRange row_px, col_px;  ///< the pixels of the image they belong to
};
/// Pads as the layers say, at the borders of the input given: what the reference trains with. Scores for as many pixels
/// as come out of the layers.
[[nodiscard]] Scores forward_padded(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input,
                                    TrainingMode mode);

/// Tensors of a model file <-> parameters. Names are those of the layers, kernels H x W x I x O (depthwise H x W x C x
/// 1). `source` names the file in messages. Throws InputError for missing tensors and wrong shapes.
[[nodiscard]] NetworkParams params_from_file(const NetworkGraph& graph, const TensorFile& file,
                                             const std::string& source);
/// `kernels_as`: batch norm vectors and biases stay F32, they are few.
[[nodiscard]] TensorFile file_from_params(const NetworkGraph& graph, const NetworkParams& params,
                                          TensorType kernels_as);

/// `bytes`: of `count` images, one after the other.
[[nodiscard]] InputTensors input_tensors(const NetworkGraph& graph, const NetworkInput& bytes, int count, int width,
                                         int height);

}  // namespace orthodrive
