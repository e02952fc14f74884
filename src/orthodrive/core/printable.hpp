// SPDX-License-Identifier: Apache-2.0
#pragma once
// Text out of files, for messages.

#include <string>

namespace orthodrive {

/// The text with '?' for control characters: a message that quotes a damaged file stays one line.
[[nodiscard]] inline std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

}  // namespace orthodrive
