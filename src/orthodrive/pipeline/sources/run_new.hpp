// SPDX-License-Identifier: Apache-2.0
#pragma once
// `orthodrive new`: reads the area and the catalogue, writes a site file.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/pipeline/sources/new_site.hpp"

namespace orthodrive {

struct RunNewOptions {
  std::string bbox;                      ///< "west,south,east,north"
  std::filesystem::path place;           ///< GeoJSON
  std::optional<std::int64_t> relation;  ///< with relation_file
  std::filesystem::path relation_file;
  NewSiteOptions site;  ///< name and ids of sources; the area is read here
  std::vector<std::filesystem::path> photo_files;
  std::filesystem::path osm_file;
  std::vector<std::filesystem::path> dtm_files;
  std::filesystem::path catalogue;  ///< folder; empty: that of the tool
  std::filesystem::path out;
  bool force = false;
  bool list = false;  ///< the table of sources in place of a file
};

struct RunNewResult {
  std::string text;  ///< for standard output: the table, or the path of the site file
  Findings findings;
};

/// Throws OptionError for an area that cannot be and a site file that is there (without `force`), InputError for files
/// that are missing or hold no area.
[[nodiscard]] RunNewResult run_new(const RunNewOptions& options);

}  // namespace orthodrive
