// SPDX-License-Identifier: Apache-2.0
#pragma once
// Names out of data that become names of files.

#include <algorithm>
#include <string_view>

namespace orthodrive {

/// Whether a file of this name lies in the folder that it is put into: no separators, no control characters, not
/// hidden, not empty, at most 200 bytes (a suffix still fits in a file system's 255).
[[nodiscard]] inline bool is_plain_name(std::string_view name) {
  constexpr std::size_t longest = 200;
  return !name.empty() && name.size() <= longest && name.front() != '.' &&
         std::none_of(name.begin(), name.end(), [](char c) {
           return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
         });
}

}  // namespace orthodrive
