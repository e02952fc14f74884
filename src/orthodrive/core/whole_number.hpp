#pragma once
// Whole numbers out of JSON that others wrote. Includes nlohmann's JSON: for .cpp files.

#include <fmt/format.h>

#include <concepts>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

/// The value as a T. Throws Error where it is no whole number in T's range: nlohmann's own conversion wraps -1, and
/// what it makes of 5e126 is not defined. The message ends with what the number is of.
template <std::integral T>
[[nodiscard]] T whole_number(const nlohmann::json& value, const char* of) {
  if (value.is_number_unsigned()) {
    if (const auto number = value.get<std::uint64_t>(); std::in_range<T>(number)) return static_cast<T>(number);
  } else if (value.is_number_integer()) {
    if (const auto number = value.get<std::int64_t>(); std::in_range<T>(number)) return static_cast<T>(number);
  }
  throw Error(fmt::format("{} is no whole number from {} to {}", of, +std::numeric_limits<T>::min(),
                          +std::numeric_limits<T>::max()));
}

}  // namespace orthodrive
