// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/packed_convolution.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

namespace orthodrive {
namespace {

constexpr int panel = 16;         // outputs, as in RowProduct
constexpr int block_rows = 1024;  // times two panels: 128 KiB of weights, which stay in the second cache

constexpr float infinity = std::numeric_limits<float>::infinity();

}  // namespace

ValueRange range_of(Activation activation) {
  switch (activation) {
    case Activation::relu:
      return {0.0F, infinity};
    case Activation::relu6:
      return {0.0F, 6.0F};
    case Activation::none:
      break;
  }
  return {-infinity, infinity};
}

PackedConvolution pack_matrix(const std::vector<float>& matrix, int rows, int out) {
  PackedConvolution packed{.in = rows, .out = out, .rows = rows, .padded_out = cell_stride_of(out)};
  packed.range = range_of(Activation::none);
  packed.no_bias.assign(static_cast<std::size_t>(packed.padded_out), 0.0F);
  packed.bias = packed.no_bias;
  packed.weights.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(packed.padded_out));
  for (int block = 0; block < rows; block += block_rows)
    for (int first = 0; first < packed.padded_out; first += panel)
      for (int row = block; row < std::min(block + block_rows, rows); ++row)
        for (int k = first; k < std::min(first + panel, packed.padded_out); ++k)
          packed.weights.push_back(
              k < out
                  ? matrix[static_cast<std::size_t>(row) * static_cast<std::size_t>(out) + static_cast<std::size_t>(k)]
                  : 0.0F);
  return packed;
}

PackedConvolution pack(const Layer& layer, const LayerWeights& weights) {
  PackedConvolution packed = pack_matrix(weights.kernel, layer.kernel * layer.kernel * layer.in, layer.out);
  packed.in = layer.in;
  packed.kernel = layer.kernel;
  packed.stride = layer.stride;
  packed.padding = layer.padding;
  std::ranges::copy(weights.bias, packed.bias.begin());
  packed.range = range_of(layer.activation);
  return packed;
}

void multiply(const LayerKernels& kernels, const PackedConvolution& matrix, const ProductPlace& place) {
  RowProduct p{.rows = place.count,
               .out = matrix.padded_out,
               .value_stride = place.value_stride,
               .bias = matrix.bias.data(),
               .add = place.add,
               .add_stride = place.add_stride,
               .result = place.result,
               .result_stride = place.result_stride};
  for (int first = 0; first < matrix.rows; first += block_rows) {
    p.in = std::min(block_rows, matrix.rows - first);
    p.values = place.values + first;
    p.weights = matrix.weights.data() + static_cast<std::size_t>(first) * static_cast<std::size_t>(matrix.padded_out);
    p.range = first + p.in == matrix.rows ? matrix.range : range_of(Activation::none);
    kernels.product(p);
    p.bias = matrix.no_bias.data();
    p.add = place.result;
    p.add_stride = place.result_stride;
  }
}

void gather_patches(const PackedConvolution& convolution, const CellView& source, int row, CellRange cols,
                    float* patches) {
  const auto in = static_cast<std::size_t>(convolution.in), kernel = static_cast<std::size_t>(convolution.kernel);
  const bool dense = source.cell_stride == in;
  for (int col = cols.first; col <= cols.last; ++col)
    for (std::size_t k = 0; k < kernel; ++k, patches += kernel * in) {
      const float* from = source.at(row * convolution.stride - convolution.padding + static_cast<int>(k),
                                    col * convolution.stride - convolution.padding);
      if (dense) {
        std::memcpy(patches, from, kernel * in * sizeof(float));
      } else {
        for (std::size_t j = 0; j < kernel; ++j)
          std::memcpy(patches + j * in, from + j * source.cell_stride, in * sizeof(float));
      }
    }
}

}  // namespace orthodrive
