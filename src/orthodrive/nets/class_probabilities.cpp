// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/class_probabilities.hpp"

#include <cstdint>
#include <vector>

#include "orthodrive/nets/layer_kernels.hpp"

namespace orthodrive {
namespace {

std::vector<MixTap> taps_of(const UpsampledAxis& axis) {
  std::vector<MixTap> taps;
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

}  // namespace

void softmax_of_scores(float* scores, std::size_t pixels, int classes) {
  layer_kernels().softmax(scores, pixels, static_cast<std::size_t>(classes), scores);
}

void upsample_scores(const ScoreGrid& grid, const UpsampledAxis& rows, const UpsampledAxis& cols, float* scores) {
  const LayerKernels& kernels = layer_kernels();
  const auto classes = static_cast<std::size_t>(grid.classes), stride = static_cast<std::size_t>(grid.cell_stride);
  const std::size_t line = static_cast<std::size_t>(grid.width) * stride;
  const std::vector<MixTap> vertical = taps_of(rows), horizontal = taps_of(cols);
  std::vector<float> coarse(line + stride);  // the last tap may look one cell ahead, with no share
  for (const MixTap& tap : vertical) {
    const float* upper = grid.scores + tap.cell * line;
    kernels.mix(upper, tap.share_of_next > 0.0F ? upper + line : upper, tap.share_of_next, line, coarse.data());
    kernels.mix_along(coarse.data(), horizontal.data(), horizontal.size(), stride, classes, scores);
    scores += horizontal.size() * classes;
  }
}

}  // namespace orthodrive
