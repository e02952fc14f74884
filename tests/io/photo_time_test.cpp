// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/photo_time.hpp"

#include <gtest/gtest.h>

namespace orthodrive::io {
namespace {

TEST(PhotoTime, tags_are_times_or_nothing) {
  EXPECT_EQ(time_of_tag("2021:06:01 10:02:03"), "2021-06-01T10:02:03Z");
  for (const char* text :
       {"", "2021", "0000:00:00 00:00:00", "2021:13:01 10:00:00", "2021:06:01 24:00:00", "yesterday"})
    EXPECT_EQ(time_of_tag(text), std::nullopt) << text;
}

}  // namespace
}  // namespace orthodrive::io
