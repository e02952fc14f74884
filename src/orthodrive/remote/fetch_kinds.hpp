// SPDX-License-Identifier: Apache-2.0
#pragma once
// How the kinds of sources are fetched. Internal to remote.

#include "orthodrive/remote/fetch.hpp"
#include "orthodrive/remote/http/secrets.hpp"
#include "orthodrive/remote/source/source_record.hpp"

namespace orthodrive::remote {

struct FetchJob {
  const FetchSource& source;
  const SiteFrame& site;
  const FetchOptions& options;
  Monitor* monitor;
  Secrets& secrets;
  HttpClient& client;
  void info(std::string_view text) const {
    if (monitor) monitor->info(text);
  }
  /// To be called right before the local file is written.
  void about_to_place() const;
};

/// The store of tiles stays until the record is written: remove_tile_store.
FetchOutcome fetch_tiles(const FetchJob& job, SourceRecord& record);
void remove_tile_store(const FetchSource& source);
FetchOutcome fetch_raster(const FetchJob& job, SourceRecord& record);
/// The store of sheets stays until the record is written: remove_sheet_store.
FetchOutcome fetch_sheets(const FetchJob& job, SourceRecord& record);
void remove_sheet_store(const FetchSource& source);
FetchOutcome fetch_osm_extract(const FetchJob& job, SourceRecord& record);
FetchOutcome fetch_overpass(const FetchJob& job, SourceRecord& record);

/// What the record says of a raster that has just been cut.
void record_raster(const FetchJob& job, const Crs& crs, double gsd_m, SourceRecord& record, FetchOutcome& outcome);
/// Throws OptionError unless the local file is named as a GeoTIFF.
void check_raster_suffix(const FetchSource& source);
/// The last part of an address (keys hidden) as a plain name, `otherwise` where it has none; its hash keeps two servers
/// apart.
[[nodiscard]] std::string store_name(const std::string& shown_url, const std::string& otherwise);
/// "12.3 MB", "45 kB"
[[nodiscard]] std::string size_text(double bytes);

}  // namespace orthodrive::remote
