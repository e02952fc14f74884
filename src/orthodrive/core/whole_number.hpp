// SPDX-License-Identifier: Apache-2.0
#pragma once
// Whole numbers out of JSON that others wrote.

#include <concepts>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

/// The value, one of nlohmann's JSON, as a T. Throws Error where it is no whole number in T's range: the library's own
/// conversion wraps -1, and what it makes of 5e126 is not defined. The message begins with what the number is.
template <std::integral T, typename Json>
[[nodiscard]] T whole_number(const Json& value, const std::string& what) {
  if (value.is_number_unsigned()) {
    if (const auto number = value.template get<std::uint64_t>(); std::in_range<T>(number))
      return static_cast<T>(number);
  } else if (value.is_number_integer()) {
    if (const auto number = value.template get<std::int64_t>(); std::in_range<T>(number)) return static_cast<T>(number);
  }
  throw Error(what + " is no whole number from " + std::to_string(std::numeric_limits<T>::min()) + " to " +
              std::to_string(std::numeric_limits<T>::max()));
}

}  // namespace orthodrive
