// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/memory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace orthodrive {
namespace {

TEST(Memory, peak_is_reset_and_grows_again) {
  if (peak_memory_bytes() == 0) GTEST_SKIP() << "no VmHWM on this system";
  reset_peak_memory();
  const auto before = peak_memory_bytes();
  {
    std::vector<char> block(200'000'000, 1);
    EXPECT_EQ(block[199'999'999], 1);
  }
  EXPECT_GT(peak_memory_bytes(), before + 190'000'000);
}

}  // namespace
}  // namespace orthodrive
