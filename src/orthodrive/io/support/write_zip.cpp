// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/write_zip.hpp"

#include <zip.h>
#include <zlib.h>

#include <algorithm>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::io {
namespace {

bool add(zipFile archive, const ZipEntry& entry) {
  zip_fileinfo info{};
  info.tmz_date.tm_year = 1980;
  info.tmz_date.tm_mday = 1;
  info.external_fa = 0100644u << 16;  // a plain file that its owner may write
  constexpr uLong made_by_unix = 3u << 8;
  if (zipOpenNewFileInZip4_64(archive, entry.name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                              Z_DEFAULT_COMPRESSION, 0, -MAX_WBITS, DEF_MEM_LEVEL, Z_DEFAULT_STRATEGY, nullptr, 0,
                              made_by_unix, 0, entry.bytes.size() >= 0xffffffffu ? 1 : 0) != ZIP_OK)
    return false;
  constexpr std::size_t chunk = std::size_t{1} << 30;
  for (std::size_t at = 0; at < entry.bytes.size(); at += chunk) {
    const auto count = static_cast<unsigned>(std::min(chunk, entry.bytes.size() - at));
    if (zipWriteInFileInZip(archive, entry.bytes.data() + at, count) != ZIP_OK) return false;
  }
  return zipCloseFileInZip(archive) == ZIP_OK;
}

}  // namespace

void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries) {
  AtomicFile file(path);
  zipFile archive = zipOpen64(file.path().c_str(), APPEND_STATUS_CREATE);
  if (archive == nullptr) throw Error(path.string() + ": cannot be written");
  const bool added =
      std::all_of(entries.begin(), entries.end(), [&](const ZipEntry& entry) { return add(archive, entry); });
  if (zipClose(archive, nullptr) != ZIP_OK || !added) throw Error(path.string() + ": cannot be written to its end");
  file.commit();
}

}  // namespace orthodrive::io
