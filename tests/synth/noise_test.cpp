// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace orthodrive::synth {
namespace {

TEST(Noise, is_a_function_of_place_and_seed) {
  EXPECT_EQ(value_noise(3.7, -2.1, 5), value_noise(3.7, -2.1, 5));
  EXPECT_NE(value_noise(3.7, -2.1, 5), value_noise(3.7, -2.1, 6));
  EXPECT_NE(hash_lattice(1, 2, 3), hash_lattice(2, 1, 3));
}

TEST(Noise, stays_in_its_range_and_has_no_mean) {
  double sum = 0.0;
  float low = 1.0f, high = -1.0f;
  constexpr int n = 200;
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col) {
      const float v = value_noise(0.37 * col, 0.41 * row, 9);
      sum += v, low = std::min(low, v), high = std::max(high, v);
      const float u = unit_hash(col, row, 9);
      ASSERT_TRUE(u >= 0.0f && u < 1.0f);
    }
  EXPECT_GE(low, -1.0f);
  EXPECT_LE(high, 1.0f);
  EXPECT_LT(low, -0.8f);
  EXPECT_GT(high, 0.8f);
  EXPECT_NEAR(sum / (n * n), 0.0, 0.03);
}

TEST(Noise, goes_through_its_lattice_values_without_a_kink) {
  EXPECT_FLOAT_EQ(value_noise(4.0, 7.0, 2), signed_hash(4, 7, 2));
  constexpr double h = 1e-3;
  for (const double x : {4.0, 5.0, -3.0}) {
    const double before = (value_noise(x, 0.3, 2) - value_noise(x - h, 0.3, 2)) / h,
                 after = (value_noise(x + h, 0.3, 2) - value_noise(x, 0.3, 2)) / h;
    EXPECT_NEAR(before, after, 0.02);
  }
}

}  // namespace
}  // namespace orthodrive::synth
