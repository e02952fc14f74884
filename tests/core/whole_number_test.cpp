// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/whole_number.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace orthodrive {
namespace {

template <typename T>
T number_in(const char* text) {
  return whole_number<T>(nlohmann::json::parse(text), "a count");
}

TEST(WholeNumber, is_taken_in_its_range) {
  EXPECT_EQ(number_in<std::uint8_t>("255"), 255);
  EXPECT_EQ(number_in<int>("-3"), -3);
  EXPECT_EQ(number_in<std::int64_t>("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(number_in<std::uint64_t>("18446744073709551615"), std::numeric_limits<std::uint64_t>::max());
}

TEST(WholeNumber, what_does_not_fit_is_told_and_not_wrapped) {
  for (const char* text : {"5e126", "1.5", "-1", "256", "18446744073709551616", "\"7\"", "null", "[7]", "true"})
    EXPECT_THAT([&] { (void)number_in<std::uint8_t>(text); },
                testing::ThrowsMessage<Error>("a count is no whole number from 0 to 255"))
        << text;
  EXPECT_THROW((void)number_in<std::size_t>("-1"), Error);
  EXPECT_THROW((void)number_in<std::int64_t>("9223372036854775808"), Error);
}

}  // namespace
}  // namespace orthodrive
