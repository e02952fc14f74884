// SPDX-License-Identifier: Apache-2.0
#include "vehicle/read_car.hpp"

#include <fstream>
#include <stdexcept>
#include <string>

namespace vehicle {
namespace {
constexpr std::size_t largest_file_bytes = 1000000;
}

CarParameters read_car(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text(largest_file_bytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.eof()) {
    const bool opened = in.is_open() && !in.bad();
    throw std::runtime_error(file.string() + (opened ? ": larger than 1 MB, not a car" : ": cannot be read"));
  }
  text.resize(static_cast<std::size_t>(in.gcount()));
  return parse_car(text, file.string());
}

}  // namespace vehicle
