// SPDX-License-Identifier: Apache-2.0
#pragma once
// Scores of a network -> class probabilities of pixels, the last step of a prediction.

#include <cstddef>

namespace orthodrive {

/// Softmax of every pixel, in place: pixels x classes, dense.
void softmax_of_scores(float* scores, std::size_t pixels, int classes);

/// Height x width cells, row-major, `cell_stride` floats apart.
struct ScoreGrid {
  const float* scores = nullptr;
  int width = 0, height = 0, classes = 0, cell_stride = 0;
};

/// Along one axis: the pixels first_px ... first_px + count - 1 of a grid of `factor` times the resolution, whose cells
/// the score grid holds from first_cell on. Pixel o lies at (o + 0.5) / factor - 0.5 cells.
struct UpsampledAxis {
  int first_px = 0, first_cell = 0, count = 0, factor = 2;
};
/// Bilinear interpolation; writes rows.count x cols.count x classes.
void upsample_scores(const ScoreGrid& grid, const UpsampledAxis& rows, const UpsampledAxis& cols, float* scores);

}  // namespace orthodrive
