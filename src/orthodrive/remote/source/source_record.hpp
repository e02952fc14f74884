// SPDX-License-Identifier: Apache-2.0
#pragma once
// FILE.source.json beside a fetched file: where it comes from, under which licence, and what was asked for.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "orthodrive/model/site_frame.hpp"
#include "orthodrive/remote/source/fetch_source.hpp"

namespace orthodrive::remote {

struct SourceRecord {
  std::string url;      ///< without keys
  std::string request;  ///< hash of the table and the area
  std::string crs, zoom, etag, last_modified;
  double resolution_m = 0.0;
  std::int64_t tiles = 0, missing = 0, sheets = 0, bytes = 0;
};

enum class LocalState {
  absent,
  complete,   ///< fetched for this table and area
  outdated,   ///< fetched for another table or area, or killed before its record was written
  users_own,  ///< there without a record: not ours to replace
};

[[nodiscard]] std::filesystem::path record_file(const FetchSource& source);
/// FILE.placing is there from before the file takes its place until its record is written: a file without a record
/// beside it is of a killed fetch, not of the user.
[[nodiscard]] std::filesystem::path placing_mark(const FetchSource& source);
/// Of the table (keys by their names alone) and the area, to a millimetre.
[[nodiscard]] std::string request_hash(const FetchSource& source, const SiteFrame& site);
[[nodiscard]] LocalState local_state(const FetchSource& source, const SiteFrame& site);
/// With licence, attribution and vertical reference of the table, and today's date.
void write_record(const FetchSource& source, const SourceRecord& record);

}  // namespace orthodrive::remote
