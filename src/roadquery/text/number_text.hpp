// SPDX-License-Identifier: Apache-2.0
#pragma once
// Numbers out of text, whatever the locale.

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <type_traits>

namespace roadquery {

/// As std::from_chars, also where the standard library has it for integers only (libc++ before 20, for WebAssembly).
template <typename T>
std::from_chars_result number_from_text(std::string_view text, T& value) {
  const char *first = text.data(), *last = text.data() + text.size();
#ifndef __cpp_lib_to_chars
  if constexpr (std::is_floating_point_v<T>) {
    constexpr std::size_t longest = 400;  // of a number written out
    constexpr std::string_view begins = "-.0123456789";
    char copy[longest + 1];
    const std::size_t size = std::min(text.size(), longest);
    std::memcpy(copy, first, size), copy[size] = '\0';
    for (std::size_t i = 0; i < size; ++i)  // no hexadecimal numbers
      if (copy[i] == 'x' || copy[i] == 'X') copy[i] = '\0';
    char* end = copy;
    if (size > 0 && begins.find(copy[0]) != std::string_view::npos) value = static_cast<T>(std::strtod(copy, &end));
    if (end == copy) return {first, std::errc::invalid_argument};
    return {first + (end - copy), std::errc{}};
  } else
#endif
  {
    return std::from_chars(first, last, value);
  }
}

}  // namespace roadquery
