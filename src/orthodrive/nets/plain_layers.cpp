// SPDX-License-Identifier: Apache-2.0
// Local response normalisation across 5 channels: Krizhevsky et al., 2012, section 3.3; appendix B of the thesis.
#include "orthodrive/nets/plain_layers.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "orthodrive/nets/fused_layers.hpp"

namespace orthodrive {
namespace {

constexpr int patch_cells = 128;  // so many cells of a row at once: their patches fit into the cache
constexpr int depthwise_side = 3;
constexpr int lrn_size = 5;
constexpr float lrn_alpha = 1e-4F;  // with the exponent 3/4

/// Rounded down; so that a position within a stride is never negative.
int floor_of_ratio(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }
int position_in(int cell, int stride) { return cell - stride * floor_of_ratio(cell, stride); }

void fill_up(std::vector<float>& values, int channels, std::size_t rows) {
  const auto from = static_cast<std::size_t>(channels), to = static_cast<std::size_t>(cell_stride_of(channels));
  std::vector<float> filled(rows * to, 0.0F);
  for (std::size_t r = 0; r < rows; ++r)
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(r * from), from,
                filled.begin() + static_cast<std::ptrdiff_t>(r * to));
  values = std::move(filled);
}

/// Taps of the kernel, along one axis, that reach an output cell at a position within a stride: tap, tap - stride, ...
/// see the input cells from the first one on.
struct DeconvolutionTaps {
  std::vector<int> taps;
  int first_input = 0;  ///< relative to the output cell's stride
};
DeconvolutionTaps taps_at(const Layer& layer, int position) {
  DeconvolutionTaps found;  // output o takes tap k of input i where i * stride - padding + k = o
  const int shifted = position + layer.padding, last = layer.kernel - 1;
  found.first_input = floor_of_ratio(shifted - last + layer.stride - 1, layer.stride);
  for (int i = found.first_input; shifted - i * layer.stride >= 0; ++i)
    found.taps.push_back(shifted - i * layer.stride);
  return found;
}

/// The rows of the kernel that outputs at one position within a stride see, as a square matrix of patches. Positions
/// that fewer taps reach get zeros, so that all have the same kernel.
PackedConvolution pack_position(const Layer& layer, const LayerWeights& weights, int row, int col) {
  const DeconvolutionTaps rows = taps_at(layer, row), cols = taps_at(layer, col);
  const auto edge = static_cast<int>(std::max(rows.taps.size(), cols.taps.size()));
  const std::size_t block = static_cast<std::size_t>(layer.in) * static_cast<std::size_t>(layer.out);
  std::vector<float> matrix(static_cast<std::size_t>(edge * edge) * block, 0.0F);
  for (std::size_t y = 0; y < rows.taps.size(); ++y)
    for (std::size_t x = 0; x < cols.taps.size(); ++x)
      std::copy_n(
          weights.kernel.begin() +
              static_cast<std::ptrdiff_t>(static_cast<std::size_t>(rows.taps[y] * layer.kernel + cols.taps[x]) * block),
          block, matrix.begin() + static_cast<std::ptrdiff_t>((y * static_cast<std::size_t>(edge) + x) * block));
  PackedConvolution packed = pack_matrix(matrix, edge * edge * layer.in, layer.out);
  packed.in = layer.in;
  packed.kernel = edge;
  std::ranges::copy(weights.bias, packed.bias.begin());
  return packed;
}

ProductPlace place_in(const Cells& output, float* result, std::size_t count, std::size_t step) {
  return {.count = count, .result = result, .result_stride = step * static_cast<std::size_t>(output.cell_stride)};
}

void convolve(const PackedConvolution& convolution, const CellView& source, const Cells& output) {
  const LayerKernels& kernels = layer_kernels();
  std::vector<float> patches;
  for (int row = output.rows.first; row <= output.rows.last; ++row)
    for (int first = output.cols.first; first <= output.cols.last; first += patch_cells) {
      const CellRange cols{first, std::min(first + patch_cells - 1, output.cols.last)};
      float* result = output.row(row) + static_cast<std::size_t>(first - output.cols.first) *
                                            static_cast<std::size_t>(output.cell_stride);
      ProductPlace place = place_in(output, result, static_cast<std::size_t>(cols.size()), 1);
      if (convolution.kernel == 1) {
        place.values =
            source.at(row * convolution.stride - convolution.padding, first * convolution.stride - convolution.padding);
        place.value_stride = static_cast<std::size_t>(convolution.stride) * source.cell_stride;
      } else {
        patches.resize(place.count * static_cast<std::size_t>(convolution.rows));
        gather_patches(convolution, source, row, cols, patches.data());
        place.values = patches.data();
        place.value_stride = static_cast<std::size_t>(convolution.rows);
      }
      multiply(kernels, convolution, place);
    }
}

void convolve_depthwise(const Layer& layer, const PlainLayer& made, const CellView& source, const Cells& output) {
  assert(layer.kernel == depthwise_side && layer.stride <= 2);
  DepthwiseRow d;
  d.cells = static_cast<std::size_t>(output.cols.size());
  d.channels = output.cell_stride;
  d.stride = layer.stride;
  d.weights = made.depthwise_weights.data();
  d.bias = made.depthwise_bias.data();
  d.range = range_of(layer.activation);
  for (int row = output.rows.first; row <= output.rows.last; ++row) {
    for (int k = 0; k < depthwise_side; ++k)
      d.rows[k] = source.at(row * layer.stride - layer.padding + k, output.cols.first * layer.stride - layer.padding);
    d.result = output.row(row);
    layer_kernels().depthwise(d);
  }
}

/// The cells at one position within a stride are a convolution of the input.
void deconvolve(const Layer& layer, const PlainLayer& made, const CellView& source, const Cells& output) {
  const LayerKernels& kernels = layer_kernels();
  const int s = layer.stride;
  std::vector<float> patches;
  for (int row = output.rows.first; row <= output.rows.last; ++row)
    for (int col = output.cols.first; col < output.cols.first + s && col <= output.cols.last; ++col) {
      const int row_position = position_in(row, s), col_position = position_in(col, s);
      const PackedConvolution& matrix = made.matrices[static_cast<std::size_t>(row_position * s + col_position)];
      const int first_row = floor_of_ratio(row, s) + taps_at(layer, row_position).first_input,
                first_col = floor_of_ratio(col, s) + taps_at(layer, col_position).first_input,
                count = (output.cols.last - col) / s + 1;
      float* result = output.row(row) +
                      static_cast<std::size_t>(col - output.cols.first) * static_cast<std::size_t>(output.cell_stride);
      ProductPlace place = place_in(output, result, static_cast<std::size_t>(count), static_cast<std::size_t>(s));
      patches.assign(place.count * static_cast<std::size_t>(matrix.rows), 0.0F);
      float* to = patches.data();
      const auto in = static_cast<std::size_t>(layer.in);
      for (int i = 0; i < count; ++i)
        for (int y = 0; y < matrix.kernel; ++y)
          for (int x = 0; x < matrix.kernel; ++x, to += in) {
            const int from_row = first_row + y, from_col = first_col + i + x;
            if (from_row <= source.rows.last && from_col <= source.cols.last)  // else a tap of weight zero
              std::memcpy(to, source.at(from_row, from_col), in * sizeof(float));
          }
      place.values = patches.data();
      place.value_stride = static_cast<std::size_t>(matrix.rows);
      multiply(kernels, matrix, place);
    }
}

/// Calls for every cell of the output: its row, column and values.
template <typename Compute>
void for_each_cell(const Cells& output, const Compute& compute) {
  for (int row = output.rows.first; row <= output.rows.last; ++row) {
    float* out = output.row(row);
    for (int col = output.cols.first; col <= output.cols.last; ++col, out += output.cell_stride) compute(row, col, out);
  }
}

void pool(const Layer& layer, const CellView& source, const Cells& output) {
  for_each_cell(output, [&](int row, int col, float* out) {
    const int top = row * layer.stride - layer.padding, left = col * layer.stride - layer.padding;
    std::copy_n(source.at(top, left), source.channels, out);
    for (int y = 0; y < layer.kernel; ++y)
      for (int x = 0; x < layer.kernel; ++x) {
        const float* from = source.at(top + y, left + x);
        for (std::size_t c = 0; c < source.channels; ++c) out[c] = std::max(out[c], from[c]);
      }
  });
}

void normalise_across_channels(const CellView& source, const Cells& output) {
  constexpr std::size_t side = lrn_size / 2;
  for_each_cell(output, [&](int row, int col, float* out) {
    const float* from = source.at(row, col);
    for (std::size_t c = 0; c < source.channels; ++c) {
      float sum = 0.0F;
      for (std::size_t k = c < side ? 0 : c - side; k <= std::min(c + side, source.channels - 1); ++k)
        sum += from[k] * from[k];
      const float root = std::sqrt(1.0F + (lrn_alpha / lrn_size) * sum);  // x^(3/4) of square roots, which are exact
      out[c] = from[c] / (root * std::sqrt(root));
    }
  });
}

void add(const Layer& layer, const std::vector<CellView>& inputs, const Cells& output) {
  for_each_cell(output, [&](int row, int col, float* out) {
    const float *a = inputs[0].at(row + layer.shifts[0], col + layer.shifts[0]),
                *b = inputs[1].at(row + layer.shifts[1], col + layer.shifts[1]);
    for (int c = 0; c < output.channels; ++c) out[c] = a[c] + b[c];
  });
}

void concatenate(const std::vector<CellView>& inputs, const Cells& output) {
  for_each_cell(output, [&](int row, int col, float* out) {
    for (const CellView& input : inputs) out = std::copy_n(input.at(row, col), input.channels, out);
  });
}

void upsample(const CellView& source, const Cells& output) {
  std::vector<float> scratch;
  for (int row = output.rows.first; row <= output.rows.last; ++row)
    upsample_row(layer_kernels(), source, row, output.cols, scratch, output.row(row));
}

}  // namespace

PlainLayer make_plain_layer(const Layer& layer, const LayerWeights& weights) {
  PlainLayer made;
  if (layer.kind == LayerKind::deconvolution) {
    for (int row = 0; row < layer.stride; ++row)
      for (int col = 0; col < layer.stride; ++col) made.matrices.push_back(pack_position(layer, weights, row, col));
  } else if (layer.kind == LayerKind::convolution && !layer.depthwise) {
    made.matrices.push_back(pack(layer, weights));
  } else if (layer.kind == LayerKind::convolution) {
    made.depthwise_weights = weights.kernel;
    made.depthwise_bias = weights.bias;
    fill_up(made.depthwise_weights, layer.out, static_cast<std::size_t>(layer.kernel * layer.kernel));
    fill_up(made.depthwise_bias, layer.out, 1);
  }
  return made;
}

void run_plain(const Layer& layer, const PlainLayer& made, const std::vector<CellView>& inputs, const Cells& output) {
  switch (layer.kind) {
    case LayerKind::convolution:
      return layer.depthwise ? convolve_depthwise(layer, made, inputs[0], output)
                             : convolve(made.matrices[0], inputs[0], output);
    case LayerKind::deconvolution:
      return deconvolve(layer, made, inputs[0], output);
    case LayerKind::max_pool:
      return pool(layer, inputs[0], output);
    case LayerKind::local_response_norm:
      return normalise_across_channels(inputs[0], output);
    case LayerKind::add:
      return add(layer, inputs, output);
    case LayerKind::concat:
      return concatenate(inputs, output);
    case LayerKind::upsample_2x:
      return upsample(inputs[0], output);
  }
}

}  // namespace orthodrive
