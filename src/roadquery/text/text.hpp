// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small things that readers of text need, the same in every locale.

#include <string>
#include <string_view>

namespace roadquery {

constexpr std::string_view blanks = " \t\r\n\v\f";

/// Without blanks at both ends.
[[nodiscard]] constexpr std::string_view trimmed(std::string_view text, std::string_view blank = blanks) {
  const std::size_t first = text.find_first_not_of(blank);
  return first == std::string_view::npos ? std::string_view{}
                                         : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

/// With a to z in place of A to Z.
[[nodiscard]] inline std::string lowered(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

}  // namespace roadquery
