// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/printable.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

TEST(Printable, control_characters_are_seen_and_words_stay) {
  EXPECT_EQ(printable("a\nb\tc\x7f"), "a?b?c?");
  EXPECT_EQ(printable("Straße"), "Straße");
}

}  // namespace
}  // namespace orthodrive
