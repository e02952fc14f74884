// SPDX-License-Identifier: Apache-2.0
#pragma once
// The [[fetch]] tables of a site file.

#include <toml++/toml.h>

#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/remote/source/fetch_source.hpp"

namespace orthodrive {

/// None where the file has no such table. Throws InputError with the line for what cannot be used.
[[nodiscard]] std::vector<remote::FetchSource> read_fetch_tables(const toml::table& site,
                                                                 const std::filesystem::path& file);

/// The site's own texts, and one for each fetched source that they do not name.
[[nodiscard]] std::vector<std::string> merged_attribution(std::vector<std::string> texts,
                                                          const std::vector<remote::FetchSource>& sources);

}  // namespace orthodrive
