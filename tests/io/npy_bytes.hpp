// SPDX-License-Identifier: Apache-2.0
#pragma once
// Arrays as numpy saves them (NEP 1, format 1.0).

#include <fmt/format.h>

#include <string>
#include <vector>

namespace orthodrive {

template <typename T>
inline std::string npy(const std::string& type, const std::string& shape, const std::vector<T>& values,
                       const std::string& order = "False") {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}", type, order, shape);
  header.resize((header.size() + 10 + 1 + 63) / 64 * 64 - 10 - 1, ' ');
  header += '\n';
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() % 256);
  bytes += static_cast<char>(header.size() / 256);
  bytes += header;
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return bytes;
}

}  // namespace orthodrive
