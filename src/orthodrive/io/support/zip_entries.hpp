// SPDX-License-Identifier: Apache-2.0
#pragma once
// What lies in a ZIP archive, by the names under which GDAL opens it in place. Internal to io.

#include <filesystem>
#include <string>
#include <vector>

namespace orthodrive::io {

/// By its first bytes.
[[nodiscard]] bool is_zip(const std::filesystem::path& file);
[[nodiscard]] bool is_gzip(const std::filesystem::path& file);
/// Of the files in all folders of the archive, in the order of their names. Throws InputError that begins with `shown`
/// for a damaged archive, one of more than 10 000 entries, and one with an entry of more than 16 GB.
[[nodiscard]] std::vector<std::string> zip_entries(const std::filesystem::path& file, const std::string& shown);
/// The path in the archive of such a name.
[[nodiscard]] std::string name_in_zip(const std::string& entry);

}  // namespace orthodrive::io
