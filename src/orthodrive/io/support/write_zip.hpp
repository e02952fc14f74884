// SPDX-License-Identifier: Apache-2.0
#pragma once
// Zip archives with the same bytes for the same content.

#include <filesystem>
#include <string>
#include <vector>

namespace orthodrive::io {

struct ZipEntry {
  std::string name;  ///< in the archive, with slashes
  std::string bytes;
};

/// Entries in the given order, deflated, dated 1980-01-01. Throws Error when it cannot be written.
void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries);

}  // namespace orthodrive::io
