// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/site_fetch.hpp"

#include <algorithm>
#include <set>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"

namespace orthodrive {
namespace {
using remote::FetchKind;
using remote::FetchSource;

FetchSource read_table(TomlSection& section, const std::filesystem::path& folder) {
  FetchSource source;
  for (const char* key : {"to", "kind"}) section.require(key);
  std::string kind;
  section.read("kind", kind), section.read("to", source.to_text), section.read("url", source.url),
      section.read("urls", source.urls);
  try {
    source.kind = remote::fetch_kind_of(kind);
  } catch (const OptionError& error) {
    section.fail_here(error.what());
  }
  if (source.to_text.empty()) section.fail_here("'to' must be a file");
  source.folder = folder, source.to = (folder / source.to_text).lexically_normal();
  if (source.url.empty() && source.urls.empty()) section.fail_here("'url' is missing here");
  const bool rasters = remote::is_raster(source.kind);
  const bool listed = rasters && source.kind != FetchKind::stac && source.kind != FetchKind::atom;
  if (!source.urls.empty() && !(listed && source.url.empty()))
    section.fail_here("'urls' is for kind raster, cog and sheets, in place of 'url'");
  source.resolution_m = rasters ? 0.0 : source.resolution_m;
  section.read("resolution_m", source.resolution_m);
  if (!(source.resolution_m >= 0.001 || (rasters && source.resolution_m == 0.0)) || source.resolution_m > 10000.0)
    section.fail_here("'resolution_m' must be metres a pixel, from 0.001 to 10000");
  section.read("min_zoom", source.min_zoom), section.read("max_zoom", source.max_zoom);
  if (source.min_zoom < 0 || source.max_zoom > 30 || source.min_zoom > source.max_zoom)
    section.fail_here("'min_zoom' and 'max_zoom' must be 0 to 30, the first not above the second");
  section.read("subdomains", source.subdomains), section.read("layer", source.layer),
      section.read("style", source.style);
  section.read("format", source.format), section.read("tile_matrix_set", source.tile_matrix_set),
      section.read("time", source.time);
  section.read("licence", source.licence), section.read("attribution", source.attribution);
  section.read("crs", source.crs);
  if (!source.crs.empty() && !rasters) section.fail_at("crs", "is for kinds that become a GeoTIFF of rasters");
  if (!source.crs.empty()) section.at("crs", [&] { (void)proj_string({source.crs}); });
  section.read("vertical_datum", source.vertical_datum), section.read("vertical_unit", source.vertical_unit);
  if ((source.kind == FetchKind::wmts || source.kind == FetchKind::wms) && source.layer.empty())
    section.fail_here(fmt::format("'layer' is missing here, kind {} needs it", kind));
  static const std::set<std::string> units{"", "m", "ft", "us-ft"};
  if (!units.contains(source.vertical_unit)) section.fail_here("'vertical_unit' must be \"m\", \"ft\" or \"us-ft\"");
  return source;
}
}  // namespace

std::vector<FetchSource> read_fetch_tables(const toml::table& site, const std::filesystem::path& file) {
  std::vector<FetchSource> sources;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  TomlSection whole(site, file);
  std::set<std::filesystem::path> targets;
  whole.for_each_table("fetch", [&](TomlSection& section) {
    sources.push_back(read_table(section, folder));
    if (!targets.insert(sources.back().to).second)
      section.fail_here(fmt::format("'{}' is the file of an earlier [[fetch]], too", sources.back().to_text));
  });
  return sources;
}

std::vector<std::string> merged_attribution(std::vector<std::string> texts, const std::vector<FetchSource>& sources) {
  for (const FetchSource& source : sources) {
    if (source.attribution.empty()) continue;
    const bool named = std::any_of(texts.begin(), texts.end(), [&](const std::string& text) {
      return text.find(source.attribution) != std::string::npos;
    });
    const bool whole = source.licence.empty() || source.attribution.find(source.licence) != std::string::npos;
    if (!named) texts.push_back(whole ? source.attribution : source.attribution + ", " + source.licence);
  }
  return texts;
}

}  // namespace orthodrive
