// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/plain_name.hpp"

#include <gtest/gtest.h>

#include <string>

namespace orthodrive {
namespace {

TEST(PlainName, stays_in_its_folder) {
  for (const char* name : {"a", "town 1", "Žižkov", "a.b", "a..b", "-", "200x200"})
    EXPECT_TRUE(is_plain_name(name)) << name;
  for (const char* name : {"", ".", "..", "../a", "a/b", "/a", "a/", "a\\b", ".a", "a\nb", "a\x7f"})
    EXPECT_FALSE(is_plain_name(name)) << name;
  EXPECT_FALSE(is_plain_name(std::string("a\0b", 3)));
  EXPECT_TRUE(is_plain_name(std::string(200, 'a')));
  EXPECT_FALSE(is_plain_name(std::string(201, 'a')));
}

}  // namespace
}  // namespace orthodrive
