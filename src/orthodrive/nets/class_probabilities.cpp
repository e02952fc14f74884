// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/class_probabilities.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

// Copies for wider vector units are chosen when the program starts.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define ORTHODRIVE_WIDE __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ORTHODRIVE_WIDE
#endif

namespace orthodrive {
namespace {

/// exp for x <= 0, relative error below 2e-7: 2^n times a polynomial on half an octave to both sides (Cephes, expf).
inline float exp_of_negative(float x) {
  x = std::max(x, -87.0F);
  const float n = static_cast<float>(static_cast<int>(x * 1.44269504F - 0.5F));
  const float r = (x - n * 0.693359375F) + n * 2.12194440e-4F;
  float p = 1.9875691500e-4F;
  p = p * r + 1.3981999507e-3F;
  p = p * r + 8.3334519073e-3F;
  p = p * r + 4.1665795894e-2F;
  p = p * r + 1.6666665459e-1F;
  p = p * r + 5.0000001201e-1F;
  p = p * r * r + r + 1.0F;
  return p * std::bit_cast<float>((static_cast<std::int32_t>(n) + 127) << 23);
}

ORTHODRIVE_WIDE void softmax_cells(const float* scores, std::size_t cells, std::size_t classes, float* out) {
  for (std::size_t i = 0; i < cells; ++i, scores += classes, out += classes) {
    float top = scores[0];
    for (std::size_t c = 1; c < classes; ++c) top = std::max(top, scores[c]);
    float sum = 0.0F;
    for (std::size_t c = 0; c < classes; ++c) out[c] = exp_of_negative(scores[c] - top);
    for (std::size_t c = 0; c < classes; ++c) sum += out[c];
    const float scale = 1.0F / sum;
    for (std::size_t c = 0; c < classes; ++c) out[c] *= scale;
  }
}

ORTHODRIVE_WIDE void mix(const float* a, const float* b, float share_of_b, std::size_t count, float* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = a[i] + share_of_b * (b[i] - a[i]);
}

/// Neighbours along a row: out = cells of pixel o and the next, mixed.
struct Tap {
  std::size_t cell;
  float share_of_next;
};

std::vector<Tap> taps_of(const UpsampledAxis& axis) {
  std::vector<Tap> taps;
  taps.reserve(static_cast<std::size_t>(axis.count));
  for (int i = 0; i < axis.count; ++i) {
    // In units of 1 / (2 factor) cells, so that the same pixel gets the same share in every window.
    const int at = 2 * (axis.first_px + i) + 1 - axis.factor, cell = 2 * axis.factor;
    const int before = at >= 0 ? at / cell : -((cell - 1 - at) / cell);  // floor
    taps.push_back({static_cast<std::size_t>(before - axis.first_cell),
                    static_cast<float>(at - before * cell) / static_cast<float>(cell)});
  }
  return taps;
}

ORTHODRIVE_WIDE void mix_along(const float* line, const std::vector<Tap>& taps, std::size_t classes, float* out) {
  for (const Tap& tap : taps) {
    const float* left = line + tap.cell * classes;
    for (std::size_t c = 0; c < classes; ++c) out[c] = left[c] + tap.share_of_next * (left[c + classes] - left[c]);
    out += classes;
  }
}

}  // namespace

void softmax_of_scores(const ScoreGrid& grid, float* probabilities) {
  softmax_cells(grid.scores, static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                static_cast<std::size_t>(grid.classes), probabilities);
}

void upsample_scores(const ScoreGrid& grid, const UpsampledAxis& rows, const UpsampledAxis& cols, float* scores) {
  const auto classes = static_cast<std::size_t>(grid.classes);
  const std::size_t line = static_cast<std::size_t>(grid.width) * classes;
  const std::vector<Tap> vertical = taps_of(rows), horizontal = taps_of(cols);
  std::vector<float> coarse(line + classes);  // the last tap may look one cell ahead, with no share
  for (const Tap& tap : vertical) {
    const float* upper = grid.scores + tap.cell * line;
    mix(upper, tap.share_of_next > 0.0F ? upper + line : upper, tap.share_of_next, line, coarse.data());
    mix_along(coarse.data(), horizontal, classes, scores);
    scores += horizontal.size() * classes;
  }
}

}  // namespace orthodrive
