// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the sources and the programs under test are. Set in paths.cpp alone, so that no other object file depends on
// the folder of the checkout and the compiler cache serves every clone.

#include <filesystem>
#include <string>

namespace orthodrive::paths {

extern const char* const source_dir;  ///< root of the checkout
extern const char* const tool;        ///< the program `orthodrive`
extern const char* const trainer;     ///< the program `orthodrive-train`; it comes with the part train
extern const char* const test_sites;  ///< the sites that tests/pipeline builds

/// Whether a part of the tool is built.
[[nodiscard]] inline bool has_part(const std::string& name) {
  return std::filesystem::exists(std::filesystem::path(tool).parent_path() / "lib/orthodrive/parts" / (name + ".so"));
}

/// A file of the checkout, by its path from the root; "../shared/data/..." for what lies beside it.
[[nodiscard]] inline std::filesystem::path in_source(const char* relative) {
  return std::filesystem::path(source_dir) / relative;
}

}  // namespace orthodrive::paths
