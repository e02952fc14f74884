// SPDX-License-Identifier: Apache-2.0
// Included by layer_kernels_*.cpp, which name the function to define, the floats of a vector and the rows of a tile (as
// many as the registers hold). Everything but that function has internal linkage and nothing of the standard library
// is instantiated here: code for newer processors must not leak into the rest of the program.

#include <cstddef>
#include <cstdint>

#include "orthodrive/core/kernel_vectors.inl"
#include "orthodrive/nets/layer_kernels.hpp"

namespace orthodrive {
namespace {

constexpr int panel_width = 16;

template <int L>
ORTHODRIVE_INLINE typename Lanes<L>::Vector cut(typename Lanes<L>::Vector v, ValueRange range) {
  const typename Lanes<L>::Vector low = all_lanes<L>(range.low), high = all_lanes<L>(range.high);
  v = v > low ? v : low;
  return v < high ? v : high;
}

/// R rows times V vectors of L outputs. `weights` steps from vector to vector by `vector_step`, from input to input by
/// `input_step`.
template <int L, int R, int V>
ORTHODRIVE_INLINE void tile(const RowProduct& p, std::size_t row, int out, const float* weights,
                            std::size_t vector_step, std::size_t input_step) {
  using Vector = typename Lanes<L>::Vector;
  Vector sums[R][V];
  ORTHODRIVE_UNROLL for (int v = 0; v < V; ++v) {
    const Vector bias = load<L>(p.bias + out + v * L);
    ORTHODRIVE_UNROLL for (int r = 0; r < R; ++r) sums[r][v] = bias;
  }
  const float* values = p.values + row * p.value_stride;
  for (int i = 0; i < p.in; ++i, weights += input_step) {
    Vector w[V];
    ORTHODRIVE_UNROLL for (int v = 0; v < V; ++v) w[v] = load<L>(weights + static_cast<std::size_t>(v) * vector_step);
    ORTHODRIVE_UNROLL for (int r = 0; r < R; ++r) {
      const Vector value =
          all_lanes<L>(values[static_cast<std::size_t>(r) * p.value_stride + static_cast<std::size_t>(i)]);
      ORTHODRIVE_UNROLL for (int v = 0; v < V; ++v) sums[r][v] = fused(value, w[v], sums[r][v]);
    }
  }
  ORTHODRIVE_UNROLL for (int r = 0; r < R; ++r) {
    const std::size_t at = row + static_cast<std::size_t>(r);
    ORTHODRIVE_UNROLL for (int v = 0; v < V; ++v) {
      Vector y = sums[r][v];
      if (p.add) y += load<L>(p.add + at * p.add_stride + static_cast<std::size_t>(out + v * L));
      store<L>(p.result + at * p.result_stride + static_cast<std::size_t>(out + v * L), cut<L>(y, p.range));
    }
  }
}

template <int L, int V>
ORTHODRIVE_INLINE void columns(const RowProduct& p, int out, std::size_t vector_step, std::size_t input_step) {
  const float* weights = p.weights + static_cast<std::size_t>(out) * static_cast<std::size_t>(p.in);
  std::size_t row = 0;
  for (; row + ORTHODRIVE_TILE_ROWS <= p.rows; row += ORTHODRIVE_TILE_ROWS)
    tile<L, ORTHODRIVE_TILE_ROWS, V>(p, row, out, weights, vector_step, input_step);
  for (; row + 2 <= p.rows; row += 2) tile<L, 2, V>(p, row, out, weights, vector_step, input_step);
  for (; row < p.rows; ++row) tile<L, 1, V>(p, row, out, weights, vector_step, input_step);
}

void product(const RowProduct& p) {
  constexpr int lanes = ORTHODRIVE_LANES;
  int out = 0;
  if constexpr (lanes == panel_width) {  // two panels at once
    for (; out + 2 * panel_width <= p.out; out += 2 * panel_width)
      columns<lanes, 2>(p, out, static_cast<std::size_t>(p.in) * panel_width, panel_width);
  }
  for (; out + panel_width <= p.out; out += panel_width)
    columns<lanes, panel_width / lanes>(p, out, lanes, panel_width);
  if (out < p.out) columns<8, 1>(p, out, 0, 8);
}

template <int L, int S>
ORTHODRIVE_INLINE void depthwise_lanes(const DepthwiseRow& d, int channel) {
  using Vector = typename Lanes<L>::Vector;
  const auto channels = static_cast<std::size_t>(d.channels);
  Vector w[9];
  ORTHODRIVE_UNROLL for (std::size_t k = 0; k < 9; ++k) w[k] =
      load<L>(d.weights + k * channels + static_cast<std::size_t>(channel));
  const Vector bias = load<L>(d.bias + channel);
  const float* row0 = d.rows[0] + channel;
  const float* row1 = d.rows[1] + channel;
  const float* row2 = d.rows[2] + channel;
  float* out = d.result + channel;
  for (std::size_t o = 0; o < d.cells;
       ++o, out += channels, row0 += S * channels, row1 += S * channels, row2 += S * channels) {
    Vector y = bias;
    ORTHODRIVE_UNROLL for (std::size_t j = 0; j < 3; ++j) y = fused(w[j], load<L>(row0 + j * channels), y);
    ORTHODRIVE_UNROLL for (std::size_t j = 0; j < 3; ++j) y = fused(w[3 + j], load<L>(row1 + j * channels), y);
    ORTHODRIVE_UNROLL for (std::size_t j = 0; j < 3; ++j) y = fused(w[6 + j], load<L>(row2 + j * channels), y);
    store<L>(out, cut<L>(y, d.range));
  }
}

template <int S>
ORTHODRIVE_INLINE void depthwise_all(const DepthwiseRow& d) {
  constexpr int lanes = ORTHODRIVE_LANES;
  int channel = 0;
  for (; channel + lanes <= d.channels; channel += lanes) depthwise_lanes<lanes, S>(d, channel);
  if (channel < d.channels) depthwise_lanes<8, S>(d, channel);
}

void depthwise(const DepthwiseRow& d) { d.stride == 1 ? depthwise_all<1>(d) : depthwise_all<2>(d); }

void mix(const float* a, const float* b, float share_of_b, std::size_t count, float* out) {
  constexpr int lanes = ORTHODRIVE_LANES;
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const typename Lanes<lanes>::Vector from = load<lanes>(a + i);
    store<lanes>(out + i, fused(all_lanes<lanes>(share_of_b), load<lanes>(b + i) - from, from));
  }
  for (; i < count; ++i) out[i] = __builtin_fmaf(share_of_b, b[i] - a[i], a[i]);
}

/// exp for x <= 0, relative error below 2e-7: 2^n times a polynomial on half an octave to both sides (Cephes, expf).
ORTHODRIVE_INLINE float exp_of_negative(float x) {
  x = x < -87.0F ? -87.0F : x;
  const float n = static_cast<float>(static_cast<int>(x * 1.44269504F - 0.5F));
  const float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
  float p = 1.9875691500e-4F;
  p = p * r + 1.3981999507e-3F;
  p = p * r + 8.3334519073e-3F;
  p = p * r + 4.1665795894e-2F;
  p = p * r + 1.6666665459e-1F;
  p = p * r + 5.0000001201e-1F;
  p = p * r * r + r + 1.0F;
  return p * __builtin_bit_cast(float, (static_cast<std::int32_t>(n) + 127) << 23);
}

void softmax(const float* scores, std::size_t cells, std::size_t classes, float* out) {
  for (std::size_t i = 0; i < cells; ++i, scores += classes, out += classes) {
    float top = scores[0];
    for (std::size_t c = 1; c < classes; ++c) top = scores[c] > top ? scores[c] : top;
    float sum = 0.0F;
    for (std::size_t c = 0; c < classes; ++c) out[c] = exp_of_negative(scores[c] - top);
    for (std::size_t c = 0; c < classes; ++c) sum += out[c];
    const float scale = 1.0F / sum;
    for (std::size_t c = 0; c < classes; ++c) out[c] *= scale;
  }
}

void mix_along(const float* line, const MixTap* taps, std::size_t count, std::size_t cell_stride, std::size_t channels,
               float* out) {
  for (std::size_t i = 0; i < count; ++i, out += channels) {
    const float *left = line + taps[i].cell * cell_stride, *right = left + cell_stride;
    for (std::size_t c = 0; c < channels; ++c) out[c] = left[c] + taps[i].share_of_next * (right[c] - left[c]);
  }
}

}  // namespace

const LayerKernels* ORTHODRIVE_LAYER_KERNELS() {
  static constexpr LayerKernels table{product, depthwise, mix, mix_along, softmax};
  return &table;
}

}  // namespace orthodrive
