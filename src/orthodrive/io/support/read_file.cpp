// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/read_file.hpp"

#include <fstream>

#include "orthodrive/core/error.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

std::string read_file(const fs::path& path) {
  std::error_code missing;
  const auto size = fs::file_size(path, missing);
  if (missing) throw InputError(path.string(), "cannot be read: " + missing.message());
  std::string bytes(size, '\0');
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw InputError(path.string(), "cannot be read to its end");
  return bytes;
}

}  // namespace orthodrive::io
