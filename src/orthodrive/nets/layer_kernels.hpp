// SPDX-License-Identifier: Apache-2.0
#pragma once
// The inner loops of layers, compiled once per processor family (layer_kernels_*.cpp) and chosen at run time. A
// pixel's channels lie side by side and are a multiple of 8. Every sum runs in the order of its weights, so a value
// depends neither on where a row begins nor on the processor.

#include <cstddef>

#include "orthodrive/core/kernel_family.hpp"

namespace orthodrive {

/// Values are cut to [low, high]: an activation.
struct ValueRange {
  float low, high;
};

/// out = cut(bias + in * weights + add) for `rows` rows of `in` values to `out` values each.
struct RowProduct {
  std::size_t rows = 0;
  int in = 0, out = 0;
  const float* values = nullptr;
  std::size_t value_stride = 0;    ///< floats from row to row
  const float* weights = nullptr;  ///< panels of 16 outputs (the last one 8): in x 16 values each
  const float* bias = nullptr;     ///< `out` values
  const float* add = nullptr;      ///< null: nothing
  std::size_t add_stride = 0;
  ValueRange range{};
  float* result = nullptr;
  std::size_t result_stride = 0;
};

/// out[o][c] = cut(bias[c] + sum over i, j of weights[i][j][c] * rows[i][o * stride + j][c]), a 3 x 3 depthwise
/// convolution.
struct DepthwiseRow {
  std::size_t cells = 0;
  int channels = 0, stride = 1;
  const float* rows[3] = {};       ///< cells x channels, dense
  const float* weights = nullptr;  ///< 9 x channels
  const float* bias = nullptr;
  ValueRange range{};
  float* result = nullptr;  ///< cells x channels, dense
};

/// A value between a cell of a line and the next one.
struct MixTap {
  std::size_t cell = 0;
  float share_of_next = 0.0F;
};

struct LayerKernels {
  void (*product)(const RowProduct&);
  void (*depthwise)(const DepthwiseRow&);
  /// out = a + share * (b - a), value by value.
  void (*mix)(const float* a, const float* b, float share_of_b, std::size_t count, float* out);
  /// out, count x channels, dense: the taps of a line of cells that lie `cell_stride` floats apart.
  void (*mix_along)(const float* line, const MixTap* taps, std::size_t count, std::size_t cell_stride,
                    std::size_t channels, float* out);
  /// Of cells x classes, dense; `out` may be `scores`.
  void (*softmax)(const float* scores, std::size_t cells, std::size_t classes, float* out);
};

/// Those of a family that this processor can run.
[[nodiscard]] const LayerKernels& layer_kernels(KernelFamily family = kernel_family());

[[nodiscard]] const LayerKernels* plain_layer_kernels();
[[nodiscard]] const LayerKernels* avx2_layer_kernels();
[[nodiscard]] const LayerKernels* avx512_layer_kernels();

}  // namespace orthodrive
