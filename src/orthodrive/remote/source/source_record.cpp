// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/source/source_record.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/hash.hpp"

namespace orthodrive::remote {
namespace fs = std::filesystem;
using nlohmann::json;

fs::path record_file(const FetchSource& source) {
  fs::path file = source.to;
  file += ".source.json";
  return file;
}

fs::path placing_mark(const FetchSource& source) {
  fs::path file = source.to;
  file += ".placing";
  return file;
}

std::string request_hash(const FetchSource& s, const SiteFrame& site) {
  json ring = json::array();
  for (const Vec2 p : site.area.outer) ring.push_back({std::llround(p.x * 1000.0), std::llround(p.y * 1000.0)});
  json table{name_of(s.kind),
             s.url,
             s.urls,
             s.subdomains,
             s.layer,
             s.style,
             s.format,
             s.tile_matrix_set,
             s.time,
             s.resolution_m,
             s.min_zoom,
             s.max_zoom,
             s.vertical_unit,
             site.crs.definition,
             ring};
  if (!s.crs.empty()) table.push_back(s.crs);
  return hash_bytes(table.dump(-1, ' ', false, json::error_handler_t::replace));
}

LocalState local_state(const FetchSource& source, const SiteFrame& site) {
  if (!fs::exists(source.to)) return LocalState::absent;
  if (fs::exists(placing_mark(source))) return LocalState::outdated;
  std::ifstream in(record_file(source));
  if (!in) return LocalState::users_own;
  const json record = json::parse(in, nullptr, false);
  if (!record.is_object()) return LocalState::outdated;
  const auto request = record.find("request");
  const bool same = request != record.end() && *request == request_hash(source, site);
  return same ? LocalState::complete : LocalState::outdated;
}

void write_record(const FetchSource& source, const SourceRecord& r) {
  json record{{"file", source.to.filename().string()},
              {"kind", name_of(source.kind)},
              {"url", r.url},
              {"licence", source.licence},
              {"attribution", source.attribution},
              {"fetched", fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr)))},
              {"request", r.request},
              {"bytes", r.bytes}};
  const auto add = [&](const char* key, const std::string& text) {
    if (!text.empty()) record[key] = text;
  };
  add("layer", source.layer), add("style", source.style), add("time", source.time);
  add("crs", r.crs), add("zoom", r.zoom), add("etag", r.etag), add("last_modified", r.last_modified);
  add("vertical_datum", source.vertical_datum), add("vertical_unit", source.vertical_unit);
  if (r.resolution_m > 0.0) record["resolution_m"] = std::round(r.resolution_m * 1000.0) / 1000.0;
  if (r.tiles > 0) record["tiles"] = r.tiles, record["missing_tiles"] = r.missing;
  if (r.sheets > 0) record["sheets"] = r.sheets;
  write_text_file(record_file(source), record.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

}  // namespace orthodrive::remote
