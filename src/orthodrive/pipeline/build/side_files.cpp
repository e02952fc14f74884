// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/side_files.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/io/raster/photo_time.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/vector/qgis_style.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

struct Asset {
  const char *file, *key, *title, *type, *role;
};
constexpr const char* cog = "image/tiff; application=geotiff; profile=cloud-optimized";
/// Media types as IANA and STAC list them; OpenDRIVE has none of its own.
constexpr Asset outputs[] = {
    {"labels.tif", "labels", "Class of every pixel", cog, "data"},
    {"confidence.tif", "confidence", "Probability of the class, 0 to 255", cog, "data"},
    {"road_probability.tif", "road_probability", "Probability of road, 0 to 255", cog, "data"},
    {"roads.gpkg", "roads", "Centre lines, nodes with heights, carriageways", "application/geopackage+sqlite3", "data"},
    {"road_graph.geojson", "road_graph", "Roads before and after refinement", "application/geo+json", "data"},
    {"roads.xodr", "opendrive", "Road network, ASAM OpenDRIVE", "application/xml", "data"},
    {"scene/tileset.json", "tiles3d", "Scene, OGC 3D Tiles", "application/json", "data"},
    {"drive/lap.csv", "lap", "The driven lap", "text/csv", "data"},
    {"findings.geojson", "findings", "What was odd, and where", "application/geo+json", "metadata"},
    {"report.html", "report", "Report of the build", "text/html", "overview"},
    {"run.json", "run", "Versions, inputs and numbers of the build", "application/json", "metadata"}};

double rounded(double degrees) { return std::round(degrees * 1e7) / 1e7; }

struct LonLatArea {
  OrderedJson geometry, bbox;
};

LonLatArea lonlat_area(const SiteFrame& frame) {
  const CoordinateTransform lonlat_from_site(Crs{"EPSG:4326"}, frame.crs);
  Box2 box{180.0, 90.0, -180.0, -90.0};
  OrderedJson rings = OrderedJson::array();
  const auto add = [&](const Ring& ring) {
    OrderedJson points = OrderedJson::array();
    for (const Vec2 p : ring) {
      const Vec2 lonlat = lonlat_from_site.source_from_target(p);
      box = {std::min(box.min_x, lonlat.x), std::min(box.min_y, lonlat.y), std::max(box.max_x, lonlat.x),
             std::max(box.max_y, lonlat.y)};
      points.push_back({rounded(lonlat.x), rounded(lonlat.y)});
    }
    points.push_back(points.front());
    rings.push_back(std::move(points));
  };
  add(frame.area.outer);
  for (const Ring& hole : frame.area.holes) add(hole);
  return {{{"type", "Polygon"}, {"coordinates", rings}},
          {rounded(box.min_x), rounded(box.min_y), rounded(box.max_x), rounded(box.max_y)}};
}

/// Letters, digits, '-' and '_' of the name: ids become file names in catalogues.
std::string id_of(const std::string& name) {
  std::string id;
  for (const char c : name) {
    const auto u = static_cast<unsigned char>(c);
    if (std::isalnum(u) || c == '-' || c == '_')
      id += static_cast<char>(std::tolower(u));
    else if (!id.empty() && id.back() != '-')
      id += '-';
  }
  while (!id.empty() && id.back() == '-') id.pop_back();
  return id.empty() ? "site" : id;
}

/// Of the earliest and the latest photo; the widest that STAC may say where one of them has no time.
std::pair<std::string, std::string> time_of_photos(const std::vector<fs::path>& photos) {
  std::string first, last;
  for (const fs::path& photo : photos) {
    const std::optional<std::string> time = io::photo_time(photo);
    if (!time) return {"1970-01-01T00:00:00Z", "2100-01-01T00:00:00Z"};
    first = first.empty() ? *time : std::min(first, *time);  // texts of one form, which sort by time
    last = std::max(last, *time);
  }
  return {first, last};
}

OrderedJson properties_of(const Site& site, const std::string& version) {
  OrderedJson properties{{"title", site.name}};
  const auto [first, last] = time_of_photos(site.photos);
  properties["datetime"] = first == last ? OrderedJson(first) : OrderedJson(nullptr);
  if (first != last) properties["start_datetime"] = first, properties["end_datetime"] = last;
  properties["license"] = "various";
  properties["providers"] = OrderedJson::array();
  for (const std::string& text : site.attribution)
    properties["providers"].push_back({{"name", text}, {"roles", {"producer"}}});
  properties["processing:software"] = {{"orthodrive", version}};
  const std::string& crs = site.frame.crs.definition;
  const bool epsg = crs.starts_with("EPSG:") && crs.size() > 5 && crs.size() <= 12 &&
                    crs.find_first_not_of("0123456789", 5) == std::string::npos;
  properties["proj:epsg"] = epsg ? OrderedJson(std::stoi(crs.substr(5))) : OrderedJson(nullptr);
  const Box2 box = bounds_of(site.frame.area.outer);
  properties["proj:bbox"] = {box.min_x, box.min_y, box.max_x, box.max_y};
  return properties;
}

}  // namespace

std::string stac_item(const Site& site, const fs::path& out_dir, const std::string& version) {
  const LonLatArea area = lonlat_area(site.frame);
  OrderedJson assets = OrderedJson::object();
  for (const Asset& output : outputs)
    if (fs::exists(out_dir / output.file))
      assets[output.key] = {{"href", std::string("./") + output.file},
                            {"title", output.title},
                            {"type", output.type},
                            {"roles", {output.role}}};
  const OrderedJson item{{"type", "Feature"},
                         {"stac_version", "1.0.0"},
                         {"stac_extensions",
                          {"https://stac-extensions.github.io/projection/v1.1.0/schema.json",
                           "https://stac-extensions.github.io/processing/v1.1.0/schema.json"}},
                         {"id", id_of(site.name)},
                         {"geometry", area.geometry},
                         {"bbox", area.bbox},
                         {"properties", properties_of(site, version)},
                         {"links", OrderedJson::array()},
                         {"assets", assets}};
  return item.dump(1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

void write_side_files(const Site& site, const fs::path& out_dir, const std::string& version) {
  write_text_file(out_dir / "labels.qml", io::qgis_label_style(io::open_labels(out_dir / "labels.tif").classes));
  write_text_file(out_dir / "findings.qml", io::qgis_findings_style());
  write_text_file(out_dir / "road_graph.qml", io::qgis_road_graph_style());
  write_text_file(out_dir / "item.json", stac_item(site, out_dir, version));
}

}  // namespace orthodrive
