// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs of layers that prediction computes row by row: the wide tensors inside an inverted residual or a separable
// convolution (Sandler et al. 2018) stay in the cache.

#include <cstddef>
#include <vector>

#include "orthodrive/nets/packed_convolution.hpp"

namespace orthodrive {

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

/// `folded`: from fold_batch_norm(). Layers whose channels are no multiples of 8 stay as they are.
[[nodiscard]] FusionPlan fuse_layers(const NetworkGraph& graph, const std::vector<LayerWeights>& folded);
/// Every layer by itself.
[[nodiscard]] FusionPlan no_fusion(const NetworkGraph& graph);

/// The row of an upsampled layer between those of `coarse`: the channels of cells `cols`, dense. `scratch` is the line
/// that the coarse cells give before they are mixed along it.
void upsample_row(const LayerKernels& kernels, const CellView& coarse, int row, CellRange cols,
                  std::vector<float>& scratch, float* result);

/// Writes rows x cols x channels, dense. `source` and, where there is one, `upsampled` must hold all cells these need.
void run_fused(const FusedLayers& layers, const CellView& source, const CellView& upsampled, CellRange rows,
               CellRange cols, float* result);

}  // namespace orthodrive
