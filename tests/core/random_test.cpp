// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/random.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace orthodrive {
namespace {

TEST(Random, stream_is_fixed_and_moments_are_right) {
  Random a(7), b(7), c(8);
  EXPECT_EQ(a.next(), b.next());
  EXPECT_NE(a.next(), c.next());
  double sum = 0.0, square = 0.0;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double x = a.normal();
    sum += x, square += x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.02);
  EXPECT_NEAR(square / n, 1.0, 0.02);
}

}  // namespace
}  // namespace orthodrive
