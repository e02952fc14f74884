// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/site.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/osm/area_reader.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/model/site_area.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"
#include "orthodrive/pipeline/sources/catalogue.hpp"
#include "orthodrive/pipeline/sources/site_fetch.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

/// Paths as the file means them: relative to itself.
class SiteFolder {
 public:
  SiteFolder(const fs::path& file, Site& site)
      : folder_(file.has_parent_path() ? file.parent_path() : fs::path(".")), site_(site) {}
  /// Refuses what only looks like a path, and keeps where it was named.
  fs::path locate(const TomlSection& section, const char* key, const std::string& name) const {
    if (name.empty()) section.fail_at(key, "is empty; give a file, relative to the site file");
    if (name != printable(name)) section.fail_at(key, "has a control character in its path");
    for (const char* mark : {"://", "WMTS:", "WMS:", "WCS:", "/vsi"})
      if (name.find(mark) != std::string::npos)
        section.fail_at(key,
                        fmt::format("is '{}', an address and no file; put it into a [[fetch]] table, and name here "
                                    "the file that `orthodrive fetch` makes of it",
                                    name));
    const fs::path path = (folder_ / name).lexically_normal();
    section.at(key, [&] { site_.named_at.emplace(path, fmt::format("{}: '{}'", section.place_of(key), key)); });
    return path;
  }
  void read(TomlSection& section, const char* key, std::vector<fs::path>& paths) const {
    std::vector<std::string> names;
    section.read_texts(key, names);
    for (const std::string& name : names) paths.push_back(locate(section, key, name));
  }
  void read(TomlSection& section, const char* key, fs::path& path) const {
    std::string name;
    section.read(key, name);
    if (section.has(key)) path = locate(section, key, name);
  }

 private:
  fs::path folder_;
  Site& site_;
};

/// [[lon, lat], ...] or a list of such rings, each closed as in GeoJSON.
Polygon read_rings(const TomlSection& area, const toml::array& list) {
  const auto read_ring = [&](const toml::array& points) {
    Ring ring;
    for (const toml::node& node : points) {
      const toml::array* point = node.as_array();
      const auto lon = point && point->size() == 2 ? (*point)[0].value<double>() : std::nullopt;
      const auto lat = lon ? (*point)[1].value<double>() : std::nullopt;
      if (!lat) area.fail(node, "'area.polygon' must be a ring of [longitude, latitude] or a list of such rings");
      ring.push_back({*lon, *lat});
    }
    return ring;
  };
  const toml::array* first = list.empty() ? nullptr : list[0].as_array();
  std::vector<Ring> rings;
  if (first && !first->empty() && (*first)[0].is_array()) {
    for (const toml::node& node : list) {
      if (!node.is_array()) area.fail(node, "'area.polygon' must be a list of rings");
      rings.push_back(read_ring(*node.as_array()));
    }
  } else {
    rings.push_back(read_ring(list));
  }
  return io::polygon_of_rings(std::move(rings));
}

Polygon read_polygon(TomlSection& area, const fs::path& file) {
  const toml::node* node = area.find("polygon");
  Polygon polygon;
  if (node->is_array()) {
    area.at("polygon", [&] { polygon = read_rings(area, *node->as_array()); });
    return polygon;
  }
  fs::path path;
  area.read("polygon", path);
  path = (file.has_parent_path() ? path : fs::path(".") / path).lexically_normal();
  area.at("polygon", [&] { polygon = io::read_area(path); });
  return polygon;
}

std::array<double, 4> read_box(TomlSection& area, const char* key) {
  std::array<double, 4> box{};
  area.read_box(key, [&](const Box2& b) { box = {b.min_x, b.min_y, b.max_x, b.max_y}; });
  return box;
}

Vec2 middle_of(const Ring& ring) {
  const Box2 box = bounds_of(ring);
  return {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
}

SiteFrame read_bounds(TomlSection& area, const std::string& crs) {
  if (crs == "auto") area.fail_at("bounds", "needs area.crs, for example \"EPSG:32633\"");
  const auto [west, south, east, north] = read_box(area, "bounds");
  if (!(west < east && south < north && std::isfinite(east - west) && std::isfinite(north - south)))
    area.fail_at("bounds", "must be west, south, east, north in metres with west < east and south < north");
  const SiteFrame frame{{crs}, {{{west, south}, {east, south}, {east, north}, {west, north}}, {}}};
  area.at("crs", [&] { check_crs(frame.crs); });
  return frame;
}

void read_area(TomlSection area, const fs::path& file, Site& site) {
  std::string crs = "auto";
  area.read("crs", crs);
  area.read("country", site.country);
  if (area.has("country")) area.at("country", [&] { check_country(site.country); });
  for (const char* key : {"bounds", "bbox_wgs84", "polygon"}) (void)area.find(key);
  area.finish();
  const int given = int{area.has("bounds")} + int{area.has("bbox_wgs84")} + int{area.has("polygon")};
  if (given != 1)
    area.fail_here(
        "[area] needs one of bbox_wgs84 (degrees), polygon (degrees; a GeoJSON file or rings) and bounds "
        "(metres, with crs)");
  if (area.has("bounds")) {
    site.frame = read_bounds(area, crs);
    Polygon lonlat;
    area.at("bounds", [&] {
      const CoordinateTransform lonlat_from_site(site.frame.crs, Crs{"EPSG:4326"});
      site.middle_lonlat = lonlat_from_site.target_from_source(middle_of(site.frame.area.outer));
      for (const Vec2 p : site.frame.area.outer) lonlat.outer.push_back(lonlat_from_site.target_from_source(p));
    });
    area.at("crs", [&] { check_scale(site.frame.crs, site.middle_lonlat); });
    area.at("bounds", [&] { check_area(site.frame); });
    site.findings = findings_of_area(lonlat, site.frame);
    return;
  }
  const char* key = area.has("polygon") ? "polygon" : "bbox_wgs84";
  Polygon lonlat;
  if (area.has("polygon")) {
    lonlat = read_polygon(area, file);
  } else {
    const std::array<double, 4> box = read_box(area, key);
    area.at(key, [&] { lonlat = polygon_of_box(box); });
  }
  area.at(key, [&] { check_lonlat_area(lonlat); });
  site.middle_lonlat = middle_of(lonlat.outer);
  if (crs != "auto")
    area.at("crs", [&] {
      check_crs({crs});
      check_scale({crs}, site.middle_lonlat);
    });
  area.at(key, [&] { site.frame = site_frame_of(lonlat, crs); });
  site.findings = findings_of_area(lonlat, site.frame);
}

void read_sources(TomlSection sources, const SiteFolder& folder, Site& site) {
  folder.read(sources, "photo", site.photos);
  folder.read(sources, "osm", site.osm);
  folder.read(sources, "dtm", site.dtm);
  folder.read(sources, "buildings", site.buildings);
  folder.read(sources, "trees", site.trees);
  folder.read(sources, "surroundings", site.surroundings);
  folder.read(sources, "gpx", site.gpx);
  folder.read(sources, "drive_logs", site.drive_logs);
  folder.read(sources, "control_points", site.control_points);
  sources.finish();
  for (const char* key : {"photo", "osm", "dtm"}) sources.require(key);
  if (site.photos.empty()) sources.fail_at("photo", "is an empty list; name a file");
  for (auto photo = site.photos.begin(); photo != site.photos.end(); ++photo)
    if (std::find(site.photos.begin(), photo, *photo) != photo)
      sources.fail_at("photo",
                      fmt::format("names {} twice; name each photo once, the best first", photo->filename().string()));
  if (site.osm.empty()) sources.fail_at("osm", "is an empty list; name a file");
  if (site.dtm.empty()) sources.fail_at("dtm", "is an empty list; name a file");
}

/// Where the site file does not say it: that of the country in which the middle of the area lies.
void read_driving_side(TomlSection& refine, Site& site) {
  const Vec2 middle = middle_of(site.frame.area.outer);
  const std::vector<Country> countries = read_countries(catalogue_folder());
  const Country* country =
      site.country.empty() ? country_at(countries, site.middle_lonlat) : country_of(countries, site.country);
  if (country && site.country.empty()) site.country = law_at(*country, site.middle_lonlat);
  const DrivingSide usual = country ? country->driving_side : DrivingSide::right;
  std::string side = to_string(usual);
  const bool is_given = refine.has("driving_side");
  refine.read_choice("driving_side", side, {"right", "left"});
  site.driving_side = driving_side_of(side);
  if (is_given && site.driving_side == usual) return;
  const std::string where = country ? fmt::format(" ({})", country->name) : "";
  if (site.driving_side != usual)
    site.findings.push_back(
        {Severity::warning, "site.driving_side",
         fmt::format("refine.driving_side is {}, but one drives on the {} here{}", side, to_string(usual), where),
         middle.x, middle.y});
  else if (site.driving_side == DrivingSide::left)
    site.findings.push_back({Severity::info, "site.driving_side",
                             fmt::format("one drives on the {} here{}", side, where), middle.x, middle.y});
}

void read_stage_options(TomlSection& root, const SiteFolder& folder, Site& site) {
  TomlSection segment = root.section("segment");
  segment.read("model", site.model);
  segment.read("crf", site.crf);
  segment.read("adapt", site.adapt);
  segment.finish();

  TomlSection refine = root.section("refine");
  folder.read(refine, "weights", site.refine_weights);
  read_driving_side(refine, site);
  refine.finish();

  TomlSection elevate = root.section("elevate");
  elevate.read_choice("sampling", site.dtm_sampling, {"bilinear", "cubic"});
  elevate.finish();

  TomlSection network = root.section("network");
  network.read_texts("crg", site.crg);
  network.read_choice("opendrive", site.opendrive, {"1.7", "1.8"});
  network.read("junction_grids", site.junction_grids);
  std::string weather = to_string(site.weather);
  network.read_choice("weather", weather, {"dry", "wet"});
  site.weather = weather_of(weather);
  network.finish();
  if (site.junction_grids && site.opendrive != "1.8")
    network.fail_at("junction_grids", "needs network.opendrive = \"1.8\"");

  TomlSection scene = root.section("scene");
  scene.read_texts("roads", site.scene_roads);
  scene.finish();

  TomlSection drive = root.section("drive");
  drive.read("route", site.route);
  drive.finish();
}

}  // namespace

Site read_site(const fs::path& path, const std::vector<std::string>& overrides) {
  if (!fs::is_regular_file(path))
    throw InputError(path.string(),
                     "no such site file; `orthodrive new` writes one for a place on earth, `orthodrive "
                     "synth -o DIR` makes one to try");
  toml::table table = parse_toml(io::read_file(path), path);
  for (const std::string& item : overrides) override_toml(table, item);

  Site site;
  site.name = path.stem().string();
  const SiteFolder folder(path, site);
  TomlSection root(table, path);
  root.read("name", site.name);
  TomlSection area = root.section("area"), sources = root.section("sources"), truth = root.section("truth"),
              attribution = root.section("attribution");
  for (const char* key : {"segment", "refine", "elevate", "network", "scene", "drive"}) (void)root.find_table(key);
  (void)root.find("fetch");  // site_fetch.hpp reads it
  root.finish();

  read_area(std::move(area), path, site);
  read_sources(std::move(sources), folder, site);
  read_stage_options(root, folder, site);
  folder.read(truth, "dir", site.truth_dir);
  truth.finish();
  attribution.read_texts("text", site.attribution);
  attribution.finish();
  site.fetch = read_fetch_tables(table, path);
  site.attribution = merged_attribution(std::move(site.attribution), site.fetch);
  return site;
}

void require_site_files(const Site& site) {
  for (const auto& [path, place] : site.named_at) {
    std::error_code unknown;
    if (!fs::exists(path, unknown))
      throw InputError(place,
                       fmt::format("there is no {}; correct the path, or `orthodrive fetch` it when the site file "
                                   "has a [[fetch]] table for it",
                                   path.string()));
  }
}

}  // namespace orthodrive
