// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/parallel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

TEST(ParallelFor, visits_every_index_once_for_any_thread_count) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> visits(1000);
    parallel_for(visits.size(), threads, [&](std::size_t i) { ++visits[i]; });
    for (const auto& n : visits) ASSERT_EQ(n.load(), 1);
  }
  parallel_for(0, 2, [](std::size_t) { FAIL(); });
}

TEST(ParallelFor, rethrows_after_all_workers_stopped) {
  EXPECT_THROW(parallel_for(100, 2,
                            [](std::size_t i) {
                              if (i == 37) throw InputError("a.tif", "is broken");
                            }),
               InputError);
}

}  // namespace
}  // namespace orthodrive
