// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/fetch.hpp"

#include <fmt/format.h>

#include <cctype>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/remote/fetch_kinds.hpp"

namespace orthodrive::remote {

std::string size_text(double bytes) {
  return bytes >= 1e9   ? fmt::format("{:.1f} GB", bytes / 1e9)
         : bytes >= 1e6 ? fmt::format("{:.1f} MB", bytes / 1e6)
                        : fmt::format("{:.0f} kB", bytes / 1e3);
}

std::string store_name(const std::string& shown_url, const std::string& otherwise) {
  std::string name = shown_url.substr(0, shown_url.find_first_of("?#"));
  name = name.substr(name.find_last_of('/') + 1);
  if (name.size() > 100) name = name.substr(name.size() - 100);  // names of files have 255 bytes at most
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-' && c != '_') c = '_';
  return hash_bytes(shown_url).substr(0, 8) + "-" + (name.empty() ? otherwise : name);
}

void FetchJob::about_to_place() const { write_text_file(placing_mark(source), ""); }

namespace {
/// Takes the mark away when the record is written, or when nothing was placed: files take their place last of all.
struct UnmarkAtEnd {
  const FetchSource& source;
  ~UnmarkAtEnd() {
    std::error_code ignored;
    std::filesystem::remove(placing_mark(source), ignored);
  }
};

FetchOutcome fetch_kind(const FetchJob& job, SourceRecord& record) {
  switch (job.source.kind) {
    case FetchKind::cog:
    case FetchKind::raster:
      return fetch_raster(job, record);
    case FetchKind::osm_extract:
      return fetch_osm_extract(job, record);
    case FetchKind::overpass:
      return fetch_overpass(job, record);
    case FetchKind::stac:
    case FetchKind::atom:
    case FetchKind::sheets:
      return fetch_sheets(job, record);
    default:
      return fetch_tiles(job, record);
  }
}
}  // namespace

FetchOutcome fetch(const FetchSource& source, const SiteFrame& site, const FetchOptions& options, Monitor* monitor) {
  const LocalState state = local_state(source, site);
  FetchOutcome there{.taken_over = true};
  if (state == LocalState::users_own) {
    there.summary = "is there and was not made by fetch: left as it is (move it away to fetch it)";
    return there;
  }
  if (state == LocalState::complete && !options.refresh) {
    there.summary = "is there already";
    return there;
  }
  Secrets secrets;
  HttpClient client(options.http, secrets, monitor);
  remove_stale_atomic_files(source.to.has_parent_path() ? source.to.parent_path() : ".");
  SourceRecord record{.request = request_hash(source, site)};
  const FetchJob job{source, site, options, monitor, secrets, client};
  try {
    const UnmarkAtEnd unmark{source};
    FetchOutcome outcome = fetch_kind(job, record);
    if (options.dry_run) return outcome;
    record.url = secrets.hide(source.urls.empty() ? source.url : source.urls.front());
    write_record(source, record);
    if (is_tiled(source.kind)) remove_tile_store(source);
    if (is_in_sheets(source.kind)) remove_sheet_store(source);
    return outcome;
  } catch (const OptionError& error) {
    throw OptionError(secrets.hide(error.what()));
  } catch (const std::exception& error) {  // messages of libraries may quote an address
    throw Error(secrets.hide(error.what()));
  }
}

}  // namespace orthodrive::remote
