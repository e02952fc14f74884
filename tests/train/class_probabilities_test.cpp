// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/class_probabilities.hpp"

#include <ATen/ATen.h>
#include <gtest/gtest.h>

namespace orthodrive {
namespace {

TEST(ClassProbabilities, upsampling_and_softmax_agree_with_torch) {
  const at::Tensor cells = 4.0 * at::randn({1, 3, 9, 7}), memory = cells.permute({0, 2, 3, 1}).contiguous();
  for (const int factor : {1, 2, 4}) {
    const at::Tensor expected = at::softmax(at::upsample_bilinear2d(cells, {9 * factor, 7 * factor}, false), 1);
    // A part in the middle; the cells given begin at row 0, column 0.
    const int top = 2 * factor - 1, left = factor, rows = 5 * factor, cols = 4 * factor + 1;
    std::vector<float> result(static_cast<std::size_t>(rows * cols * 3));
    upsample_scores({memory.data_ptr<float>(), 7, 9, 3, 3}, {top, 0, rows, factor}, {left, 0, cols, factor},
                    result.data());
    softmax_of_scores(result.data(), static_cast<std::size_t>(rows * cols), 3);
    for (int y = 0; y < rows; ++y)
      for (int x = 0; x < cols; ++x)
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(result[static_cast<std::size_t>((y * cols + x) * 3 + c)],
                      expected[0][c][y + top][x + left].item<float>(), 2e-6);
  }
}

}  // namespace
}  // namespace orthodrive
