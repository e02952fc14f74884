#pragma once
// Scores of a network -> class probabilities of pixels, the last step of a prediction.

namespace orthodrive {

/// Height x width x classes, row-major.
struct ScoreGrid {
  const float* scores = nullptr;
  int width = 0, height = 0, classes = 0;
};

/// Softmax of every cell; `probabilities` has the same layout.
void softmax_of_scores(const ScoreGrid& grid, float* probabilities);

/// Along one axis: the pixels first_px ... first_px + count - 1 of a grid of twice the resolution, whose cells the
/// score grid holds from first_cell on. Pixel o lies at (2 o - 1) / 4 cells: a quarter from one, three from the other.
struct UpsampledAxis {
  int first_px = 0, first_cell = 0, count = 0;
};
/// Bilinear interpolation to twice the resolution, then softmax; writes rows.count x cols.count x classes.
void softmax_of_upsampled(const ScoreGrid& grid, UpsampledAxis rows, UpsampledAxis cols, float* probabilities);

}  // namespace orthodrive
