// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/sheet_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/raster/opened_rasters.hpp"
#include "orthodrive/io/support/zip_entries.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::io {
namespace {

bool may_be_raster(const std::string& name) {
  static constexpr std::array suffixes{".tif", ".tiff", ".jp2", ".j2k", ".jpg", ".jpeg", ".png", ".img", ".asc",
                                       ".xyz", ".bil",  ".bip", ".bsq", ".hgt", ".dem",  ".ecw", ".sid", ".grd"};
  const std::string lowered = roadquery::lowered(name);
  return std::any_of(suffixes.begin(), suffixes.end(), [&](const char* s) { return lowered.ends_with(s); });
}

bool has_place(const std::string& name) {
  double c[6];
  return open_raster(name, true)->GetGeoTransform(c) == CE_None;
}

/// Begins with the address in place of the name of our copy, and names the file in an archive.
[[noreturn]] void fail_shown(const std::string& shown, const std::string& name, const std::string& what) {
  const std::string inner = name_in_zip(name);
  const std::string why = what.starts_with(name) ? what.substr(std::min(what.size(), name.size() + 2)) : what;
  throw InputError(shown, inner == name ? why : printable(inner) + " in it " + why);
}
}  // namespace

std::vector<std::string> rasters_in(const std::filesystem::path& file, const std::string& shown) {
  start_gdal();
  const ScopedGdalOption with_neighbours("GDAL_DISABLE_READDIR_ON_OPEN", "FALSE");
  std::vector<std::string> candidates, placed;
  if (is_gzip(file)) {
    candidates.push_back("/vsigzip/" + std::filesystem::absolute(file).string());
  } else if (!is_zip(file)) {
    candidates.push_back(file.string());
  } else {
    const std::vector<std::string> entries = zip_entries(file, shown);
    std::copy_if(entries.begin(), entries.end(), std::back_inserter(candidates), may_be_raster);
    if (candidates.empty())
      throw InputError(shown, fmt::format("is an archive without a raster{}",
                                          entries.empty() ? "" : ", it holds " + printable(name_in_zip(entries[0]))));
  }
  for (const std::string& name : candidates) try {
      if (has_place(name)) placed.push_back(name);
    } catch (const InputError& error) {
      fail_shown(shown, name, error.what());
    }
  return placed.empty() ? candidates : placed;
}

}  // namespace orthodrive::io
