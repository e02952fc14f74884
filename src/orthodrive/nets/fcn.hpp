// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs a NetworkGraph with libtorch. Includes ATen: for the .cpp files of this folder only.

#include <ATen/ATen.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/model/tensor_file.hpp"
#include "orthodrive/nets/network_graph.hpp"

namespace orthodrive {

/// Weights of one layer. Kernels O x I x H x W in channels-last (deconvolutions I x O x H x W); then either a batch
/// norm or a bias.
struct LayerParams {
  at::Tensor kernel, gamma, beta, mean, variance, bias;
};
using NetworkParams =
    std::vector<LayerParams>;  ///< one a layer of the graph, undefined tensors where it has no weights

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

/// Class scores for the pixels of a window's inner part.
struct Scores {
  at::Tensor values;         ///< N x C x rows x cols
  CellRange row_px, col_px;  ///< the pixels of the image they belong to
};
/// Pads as the layers say, at the borders of the input given: what the reference trains with. Scores for as many pixels
/// as come out of the layers.
[[nodiscard]] Scores forward_padded(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input,
                                    TrainingMode mode);

/// Pads nothing: every layer computes exactly the cells that the wanted output depends on, so the scores are the same
/// wherever a window begins and ends. `input`: N = 1, its first pixel at absolute (image_rows.first, image_cols.first);
/// it must contain needed_ranges(), and each tensor goes when the last layer has read it. With `last_layer` false the
/// layer before the last is returned, on the cells that the last needs.
struct ExactWindow {
  CellRange image_rows, image_cols;    ///< absolute pixels of the image given
  CellRange output_rows, output_cols;  ///< absolute pixels wanted
  bool last_layer = true;
};
/// With a `plan` for these parameters (fused_layers.hpp) some layers run together.
struct FusionPlan;
[[nodiscard]] at::Tensor forward_exact(const NetworkGraph& graph, NetworkParams& params, InputTensors input,
                                       const ExactWindow& window, const FusionPlan* plan = nullptr);

/// Batch norm folded into kernel and bias: the same scores with fewer passes over memory.
[[nodiscard]] NetworkParams fold_batch_norm(const NetworkGraph& graph, const NetworkParams& params);

/// Tensors of a model file <-> parameters. Names are those of the layers, kernels H x W x I x O (depthwise H x W x C x
/// 1). `source` names the file in messages. Throws InputError for missing tensors and wrong shapes.
[[nodiscard]] NetworkParams params_from_file(const NetworkGraph& graph, const TensorFile& file,
                                             const std::string& source);
/// `kernels_as`: batch norm vectors and biases stay F32, they are few.
[[nodiscard]] TensorFile file_from_params(const NetworkGraph& graph, const NetworkParams& params,
                                          TensorType kernels_as);

/// Helpers for whoever fills parameters: shape and memory order of a layer's kernel.
[[nodiscard]] std::vector<std::int64_t> kernel_file_shape(const Layer& layer);
[[nodiscard]] at::Tensor kernel_from_file_order(const Layer& layer, const at::Tensor& hwio);
[[nodiscard]] at::Tensor tensor_from(const NamedTensor& named);
[[nodiscard]] std::string bias_tensor(const Layer& layer);

/// Bytes that a network sees, N x H x W x channels each. Without a map (null) a network that knows one sees none.
struct NetworkInput {
  const std::uint8_t* rgb = nullptr;
  const std::uint8_t* map = nullptr;  ///< map_raster_channels, as map_alignment.hpp encodes them
};
[[nodiscard]] InputTensors input_tensors(const NetworkGraph& graph, const NetworkInput& bytes, int count, int width,
                                         int height);

/// The folded network for prediction. Safe from several threads.
class InferenceNetwork {
 public:
  InferenceNetwork(NetworkGraph graph, const NetworkParams& params);
  /// `bytes` cover `core` grown by margin_px() on every side. Writes what the last layer gives for the core, (factor
  /// height) x (factor width) x output_channels(): class scores, then the alignment, at `factor` times the resolution,
  /// bilinear. It does not depend on how a mosaic is cut into cores, but for the order of summation.
  void predict(const NetworkInput& bytes, const PixelBox& core, int factor, float* scores) const;
  [[nodiscard]] int class_count() const { return graph_.class_count; }
  [[nodiscard]] bool sees_map() const { return graph_.map_channels > 0; }
  [[nodiscard]] int output_channels() const { return graph_.output_channels(); }
  [[nodiscard]] int margin_px() const { return margin_px_; }
  /// The most that is held at once while it predicts, in bytes per pixel of the image.
  [[nodiscard]] double peak_bytes_per_pixel() const { return peak_bytes_per_pixel_; }
  [[nodiscard]] const NetworkGraph& graph() const { return graph_; }

 private:
  NetworkGraph graph_;
  NetworkParams folded_;
  std::shared_ptr<const FusionPlan> plan_;
  int margin_px_ = 0;
  double peak_bytes_per_pixel_ = 0.0;
};

}  // namespace orthodrive
