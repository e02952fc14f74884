// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/zip_entries.hpp"

#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <memory>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/gdal_support.hpp"

namespace orthodrive::io {
namespace {
struct CloseFolder {
  void operator()(VSIDIR* folder) const { VSICloseDir(folder); }
};
}  // namespace

bool is_zip(const std::filesystem::path& file) {
  char start[4] = {};
  std::ifstream in(file, std::ios::binary);
  return in.read(start, 4) && std::string_view(start, 4) == "PK\x03\x04";
}

bool is_gzip(const std::filesystem::path& file) {
  char start[3] = {};
  std::ifstream in(file, std::ios::binary);
  return in.read(start, 3) && std::string_view(start, 3) == "\x1f\x8b\x08";
}

std::vector<std::string> zip_entries(const std::filesystem::path& file, const std::string& shown) {
  constexpr std::size_t most_entries = 10000;
  constexpr double most_bytes = 16e9;
  const std::string root = "/vsizip/{" + std::filesystem::absolute(file).string() + "}";
  GdalErrors errors;
  const std::unique_ptr<VSIDIR, CloseFolder> folder(VSIOpenDir(root.c_str(), -1, nullptr));
  if (!folder)
    throw InputError(shown, fmt::format("is a damaged ZIP archive{}; run it again to get it anew",
                                        errors.any() ? " (" + errors.text() + ")" : ""));
  std::vector<std::string> names;
  std::size_t count = 0;
  while (const VSIDIREntry* entry = VSIGetNextDirEntry(folder.get())) {
    if (++count > most_entries)
      throw InputError(shown, fmt::format("is an archive of more than {} files, which is not read", most_entries));
    if (static_cast<double>(entry->nSize) > most_bytes)
      throw InputError(shown, fmt::format("unpacks to {:.0f} GB, most are {:.0f}",
                                          static_cast<double>(entry->nSize) / 1e9, most_bytes / 1e9));
    if (VSI_ISREG(entry->nMode)) names.push_back(root + "/" + entry->pszName);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string name_in_zip(const std::string& entry) {
  const std::size_t end = entry.find("}/");
  return end == std::string::npos ? entry : entry.substr(end + 2);
}

}  // namespace orthodrive::io
