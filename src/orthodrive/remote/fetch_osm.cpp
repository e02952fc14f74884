// SPDX-License-Identifier: Apache-2.0
// OpenStreetMap: an extract of a region, cut here, or what Overpass answers.
#include <fmt/format.h>

#include <cstdlib>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/osm/cut_osm.hpp"
#include "orthodrive/remote/fetch_kinds.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/tiles/tile_plan.hpp"

namespace orthodrive::remote {
namespace {
namespace fs = std::filesystem;
constexpr double osm_margin_m = 300.0;  // houses and trees stand beyond the last road

void check_suffix(const FetchSource& source) {
  const std::string name = source.to.filename().string();
  if (!name.ends_with(".osm") && !name.ends_with(".osm.pbf"))
    throw OptionError(fmt::format("{}: OpenStreetMap data becomes .osm or .osm.pbf, name it so", source.to_text));
}

/// Where large files of servers are kept for all sites: ORTHODRIVE_STORE, else the user's cache.
fs::path store_folder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  if (const fs::path store = variable("ORTHODRIVE_STORE"); !store.empty()) return store;
  if (const fs::path cache = variable("XDG_CACHE_HOME"); !cache.empty()) return cache / "orthodrive";
  if (const fs::path home = variable("HOME"); !home.empty()) return home / ".cache/orthodrive";
  throw OptionError("no folder for downloads: set ORTHODRIVE_STORE to one");
}

void take_counts(const io::CutOsm& cut, const FetchJob& job, FetchOutcome& outcome, SourceRecord& record) {
  record.bytes = outcome.bytes = static_cast<std::int64_t>(fs::file_size(job.source.to));
  outcome.summary = fmt::format("{} nodes, {} ways, {} relations, {}", cut.nodes, cut.ways, cut.relations,
                                size_text(static_cast<double>(record.bytes)));
  if (record.last_modified.empty()) record.last_modified = cut.timestamp;
}
}  // namespace

FetchOutcome fetch_osm_extract(const FetchJob& job, SourceRecord& record) {
  check_suffix(job.source);
  const Box2 box = lonlat_box(job.site, osm_margin_m, job.source.to_text);
  const std::string url = job.secrets.resolve(job.source.url);
  FetchOutcome outcome;
  const bool remote = is_http(url);
  const fs::path extract = remote ? store_folder() / store_name(job.secrets.hide(url), "extract.osm.pbf")
                                  : (job.source.folder / url).lexically_normal();
  if (job.options.dry_run) {
    outcome.summary = fmt::format("the area of {}{}", extract.filename().string(),
                                  remote && !fs::exists(extract) ? ", which is downloaded whole first" : "");
    return outcome;
  }
  if (remote) {
    job.info(fmt::format("{}: {}", job.source.to_text,
                         fs::exists(extract) ? "has the extract in " + extract.string()
                                             : "downloads the extract to " + extract.string()));
    const HttpFile file = job.client.download(url, extract, job.options.refresh);
    record.etag = file.etag, record.last_modified = file.last_modified;
    if (!file.unchanged)
      job.info(fmt::format(
          "{}: {} downloaded{}", extract.filename().string(),
          size_text(static_cast<double>(file.bytes - file.resumed_at)),
          file.resumed_at > 0 ? fmt::format(", went on at {}", size_text(static_cast<double>(file.resumed_at))) : ""));
  }
  job.about_to_place();
  take_counts(io::cut_osm(extract, job.source.to, box), job, outcome, record);
  return outcome;
}

namespace {
/// Roads, buildings, trees and surroundings (what the readers of io know), with all nodes of their ways.
std::string overpass_query(const Box2& box) {
  const std::string area = fmt::format("({:.6f},{:.6f},{:.6f},{:.6f})", box.min_y, box.min_x, box.max_y, box.max_x);
  std::string parts;
  for (const char* key :
       {"highway", "building", "building:part", "railway", "waterway", "barrier", "natural", "landuse", "leisure",
        "amenity", "surface", "area:highway", "man_made", "power", "traffic_sign", "emergency"})
    parts += fmt::format("nwr[\"{}\"]{};", key, area);
  return fmt::format("[out:xml][timeout:180];({}rel[\"type\"=\"restriction\"]{};);(._;>;);out body;", parts, area);
}

/// What is wrong with an answer, in the server's words where it has some.
std::string wrong_answer(const HttpReply& reply) {
  if (const auto remark = reply.body.find("<remark>"); remark != std::string::npos) {
    const std::string said = reply.body.substr(remark + 8, reply.body.find("</remark>", remark) - remark - 8);
    return "the server says:" + printable(said.substr(0, 150));
  }
  if (reply.body.find("<osm") == std::string::npos)
    return fmt::format("the server answers {} that is no OSM data",
                       reply.content_type.empty() ? "something" : reply.content_type);
  const std::size_t end = reply.body.find_last_not_of(" \r\n\t");
  const bool whole = end != std::string::npos && std::string_view(reply.body).substr(0, end + 1).ends_with("</osm>");
  return whole ? "" : "the answer is truncated";
}
}  // namespace

FetchOutcome fetch_overpass(const FetchJob& job, SourceRecord& record) {
  check_suffix(job.source);
  const Box2 box = lonlat_box(job.site, osm_margin_m, job.source.to_text);
  FetchOutcome outcome;
  const double degrees2 = box.width() * box.height();
  if (degrees2 > 0.25)
    throw OptionError(fmt::format(
        "{}: the area has {:.2f} square degrees, too much for an Overpass query (0.25); take kind = \"osm_extract\"",
        job.source.to_text, degrees2));
  if (job.options.dry_run) {
    outcome.summary = fmt::format("one query of {:.4f} square degrees", degrees2);
    return outcome;
  }
  HttpOptions options = job.options.http;
  options.most_bytes = std::int64_t{1} << 30;
  options.stall_s = std::max(options.stall_s, 200.0);  // it answers when it is done
  HttpClient client(options, job.secrets, job.monitor);
  job.info(fmt::format("{}: asks Overpass", job.source.to_text));
  const HttpReply reply =
      client.get({.url = job.secrets.resolve(job.source.url), .post = "data=" + percent_encoded(overpass_query(box))},
                 wrong_answer);
  fs::path answer = job.source.to;
  answer.replace_filename("." + job.source.to.stem().stem().string() + ".overpass.osm");
  write_text_file(answer, reply.body);
  try {
    job.about_to_place();
    take_counts(io::cut_osm(answer, job.source.to, box), job, outcome, record);
  } catch (...) {
    fs::remove(answer);
    throw;
  }
  fs::remove(answer);
  return outcome;
}

}  // namespace orthodrive::remote
