// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/disjoint_sets.hpp"

#include <gtest/gtest.h>

#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

TEST(DisjointSets, single_numbers_are_sets_of_their_own) {
  DisjointSets sets(4);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(sets.find(i), i);
}

TEST(DisjointSets, a_set_is_named_by_its_lowest_member_whatever_the_order) {
  constexpr std::size_t count = 200;
  // Numbers of the same remainder by 7 belong together.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Random random(seed);
    DisjointSets sets(count);
    std::vector<std::size_t> order;
    for (std::size_t i = 7; i < count; ++i) order.push_back(i);
    for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.next() % (i + 1)]);
    for (const std::size_t i : order) sets.join(i, i - 7);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(sets.find(i), i % 7);
  }
}

}  // namespace
}  // namespace orthodrive
