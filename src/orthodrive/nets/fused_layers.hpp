// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs of layers that prediction computes row by row: the wide tensors inside an inverted residual or a separable
// convolution (Sandler et al. 2018) stay in the cache. Includes ATen: for the .cpp files of this folder only.

#include <cstddef>
#include <vector>

#include "orthodrive/nets/fcn.hpp"
#include "orthodrive/nets/layer_kernels.hpp"

namespace orthodrive {

/// A convolution as a matrix, (kernel x kernel x in) x out, in the panels of RowProduct.
struct PackedConvolution {
  int in = 0, out = 0, kernel = 1, stride = 1, padding = 0;
  std::vector<float> weights, bias;
  ValueRange range{};
};

/// [convolution] -> 3 x 3 depthwise -> pointwise [+ what came in]; or (2 x upsampled + pointwise) -> depthwise ->
/// pointwise.
struct FusedLayers {
  std::size_t last = 0;      ///< the layer whose output it gives
  int source = image_input;  ///< the layer it reads
  int upsampled = none;      ///< the layer whose cells are upsampled and added before the depthwise convolution
  bool expands = false;      ///< `expansion` comes before the depthwise convolution
  bool residual = false;     ///< the source is added to the result
  PackedConvolution expansion, projection;
  int channels = 0, stride = 1;  ///< of the depthwise convolution
  std::vector<float> depthwise_weights, depthwise_bias;
  ValueRange depthwise_range{};

  static constexpr int none = -3;
};

/// What a network's layers become. One entry a layer in `step`: the index of the fused layers that end there, or one of
/// the two constants.
struct FusionPlan {
  std::vector<FusedLayers> fused;
  std::vector<int> step;
  static constexpr int plain = -1, inside = -2;
};

/// `folded`: from fold_batch_norm. Layers whose channels are no multiples of 8 stay as they are.
[[nodiscard]] FusionPlan fuse_layers(const NetworkGraph& graph, const NetworkParams& folded);

/// Cells of a layer in memory, channels last.
struct CellView {
  const float* first = nullptr;  ///< the cell at rows.first, cols.first
  CellRange rows, cols;
  std::size_t channels = 0, row_stride = 0;
  [[nodiscard]] const float* at(int row, int col) const {
    return first + static_cast<std::size_t>(row - rows.first) * row_stride +
           static_cast<std::size_t>(col - cols.first) * channels;
  }
};

/// Writes rows x cols x channels, dense. `source` and, where there is one, `upsampled` must hold all cells these need.
void run_fused(const FusedLayers& layers, const CellView& source, const CellView& upsampled, CellRange rows,
               CellRange cols, float* result);

}  // namespace orthodrive
