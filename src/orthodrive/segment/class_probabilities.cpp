#include "orthodrive/segment/class_probabilities.hpp"

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

/// The cell before a pixel and how far the pixel lies towards the next.
struct Tap {
  std::size_t cell;
  float share_of_next;
};

Tap tap_of(const UpsampledAxis& axis, int index) {
  const int px = axis.first_px + index;
  const int cell = (px - 1) >= 0 ? (px - 1) / 2 : -((2 - px) / 2);  // floor
  return {static_cast<std::size_t>(cell - axis.first_cell), (px % 2 + 2) % 2 == 0 ? 0.75F : 0.25F};
}

}  // namespace

void softmax_of_scores(const ScoreGrid& grid, float* probabilities) {
  softmax_cells(grid.scores, static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height),
                static_cast<std::size_t>(grid.classes), probabilities);
}

void softmax_of_upsampled(const ScoreGrid& grid, UpsampledAxis rows, UpsampledAxis cols, float* probabilities) {
  const auto classes = static_cast<std::size_t>(grid.classes);
  const std::size_t line = static_cast<std::size_t>(grid.width) * classes;
  std::vector<float> coarse(line), fine(static_cast<std::size_t>(cols.count) * classes);
  for (int row = 0; row < rows.count; ++row) {
    const Tap vertical = tap_of(rows, row);
    const float* upper = grid.scores + vertical.cell * line;
    mix(upper, upper + line, vertical.share_of_next, line, coarse.data());
    for (int col = 0; col < cols.count; ++col) {
      const Tap horizontal = tap_of(cols, col);
      const float* left = &coarse[horizontal.cell * classes];
      float* out = &fine[static_cast<std::size_t>(col) * classes];
      for (std::size_t c = 0; c < classes; ++c)
        out[c] = left[c] + horizontal.share_of_next * (left[c + classes] - left[c]);
    }
    softmax_cells(fine.data(), static_cast<std::size_t>(cols.count), classes,
                  probabilities + static_cast<std::size_t>(row) * static_cast<std::size_t>(cols.count) * classes);
  }
}

}  // namespace orthodrive
