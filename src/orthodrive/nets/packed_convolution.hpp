// SPDX-License-Identifier: Apache-2.0
#pragma once
// Convolutions as products of matrices, in the memory order of the kernels.

#include <cstddef>
#include <vector>

#include "orthodrive/nets/cell_memory.hpp"
#include "orthodrive/nets/layer_kernels.hpp"
#include "orthodrive/nets/layer_weights.hpp"

namespace orthodrive {

[[nodiscard]] ValueRange range_of(Activation activation);

/// A convolution as a matrix, (kernel x kernel x in) x out. Its rows come in blocks that fit into the cache; the sum
/// over a block is added to that of the blocks before.
struct PackedConvolution {
  int in = 0, out = 0, kernel = 1, stride = 1, padding = 0;
  int rows = 0;                ///< kernel x kernel x in
  int padded_out = 0;          ///< a multiple of 8; the outputs beyond `out` are 0 before the activation
  std::vector<float> weights;  ///< block by block: panels of 16 outputs (the last one 8), as in RowProduct
  std::vector<float> bias, no_bias;
  ValueRange range{};
};

/// A matrix of that many rows with its `out` columns side by side.
[[nodiscard]] PackedConvolution pack_matrix(const std::vector<float>& matrix, int rows, int out);
[[nodiscard]] PackedConvolution pack(const Layer& layer, const LayerWeights& weights);

/// Where a product reads and writes.
struct ProductPlace {
  std::size_t count = 0;  ///< of products, each of `rows` values with the matrix
  const float* values = nullptr;
  std::size_t value_stride = 0;
  const float* add = nullptr;  ///< null: nothing
  std::size_t add_stride = 0;
  float* result = nullptr;
  std::size_t result_stride = 0;
};
/// result = cut(bias + values * matrix + add), padded_out values each.
void multiply(const LayerKernels& kernels, const PackedConvolution& matrix, const ProductPlace& place);

/// The input cells that each output cell of a row sees, cell by cell: dense patches of `rows` values.
void gather_patches(const PackedConvolution& convolution, const CellView& source, int row, CellRange cols,
                    float* patches);

}  // namespace orthodrive
