// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/run_new.hpp"

#include <fmt/format.h>

#include <charconv>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/area_reader.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

LonLatBox parse_box(const std::string& text) {
  LonLatBox box{};
  const char *at = text.data(), *const end = text.data() + text.size();
  for (std::size_t i = 0; i < box.size(); ++i) {
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, box[i]);
    const bool last = i + 1 == box.size();
    if (error != std::errc{} || (last ? next != end : next == end || *next != ','))
      throw OptionError(fmt::format("--bbox {}: need four numbers, west,south,east,north in degrees", text));
    at = next + (last ? 0 : 1);
  }
  return box;
}

struct ReadArea {
  Polygon polygon;
  std::optional<LonLatBox> box;
};

/// Says what of a place with several parts was taken.
Polygon largest_part(MultiPolygon parts, const std::string& where, Findings& findings) {
  if (parts.size() > 1)
    findings.push_back(
        {Severity::warning, "new.largest_part",
         fmt::format("{} has {} separate parts, and a site is one: the largest was taken", where, parts.size())});
  return std::move(parts.front());
}

/// What is wrong with the area, told with where it came from.
template <typename Body>
void naming(const std::string& where, const Body& body) {
  try {
    body();
  } catch (const OptionError& error) {
    throw InputError(where, error.what());
  }
}

std::optional<ReadArea> read_area(const RunNewOptions& options, Findings& findings) {
  ReadArea area;
  if (!options.bbox.empty()) {
    area.box = parse_box(options.bbox);
    area.polygon = polygon_of_box(*area.box);
  } else if (!options.place.empty()) {
    area.polygon = largest_part(io::read_areas(options.place), options.place.string(), findings);
    naming(options.place.string(), [&] { check_lonlat_area(area.polygon); });
  } else if (options.relation) {
    const std::string where = fmt::format("{}: relation {}", options.relation_file.string(), *options.relation);
    area.polygon = largest_part(io::read_relation(options.relation_file, *options.relation), where, findings);
    naming(where, [&] { check_lonlat_area(area.polygon); });
  } else {
    return std::nullopt;
  }
  return area;
}

/// As the site file shall name it.
std::string local_name(const fs::path& file, const fs::path& out, const char* option) {
  if (!fs::exists(file)) throw InputError(file.string(), fmt::format("no such file ({})", option));
  const fs::path folder = fs::absolute(out).parent_path();
  return fs::proximate(fs::absolute(file).lexically_normal(), folder.lexically_normal()).string();
}

}  // namespace

RunNewResult run_new(const RunNewOptions& options) {
  RunNewResult result;
  const std::optional<ReadArea> area = read_area(options, result.findings);
  if (!area && !options.list)
    throw OptionError(
        "new: which place? give --bbox west,south,east,north, --place FILE.geojson or --relation ID --osm FILE");
  const Catalogue catalogue = read_catalogue(options.catalogue.empty() ? catalogue_folder() : options.catalogue);
  if (options.list) {
    result.text = source_table(catalogue, area ? &area->polygon : nullptr);
    return result;
  }
  if (options.out.empty()) throw OptionError("new: where to? give -o site.toml");
  if (fs::exists(options.out) && !options.force)
    throw OptionError(fmt::format("{}: is there already; --force replaces it", options.out.string()));
  NewSiteOptions site = options.site;
  site.area = area->polygon;
  site.box = area->box;
  if (site.name.empty()) site.name = options.out.stem().string();
  for (const fs::path& file : options.photo_files)
    site.photo_files.push_back(local_name(file, options.out, "--photo-file"));
  if (!options.osm_file.empty()) site.osm_file = local_name(options.osm_file, options.out, "--osm-file");
  for (const fs::path& file : options.dtm_files) site.dtm_files.push_back(local_name(file, options.out, "--dtm-file"));
  const NewSite made = new_site(catalogue, site);
  write_text_file(options.out, made.text);
  result.findings.insert(result.findings.end(), made.findings.begin(), made.findings.end());
  result.text = options.out.string() + "\n";
  return result;
}

}  // namespace orthodrive
