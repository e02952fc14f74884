// SPDX-License-Identifier: Apache-2.0
// Features of GeoJSON and GeoPackage through OGR; findings and other small things as GeoJSON.

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/geojson_support.hpp"
#include "orthodrive/io/support/ogr_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
bool is_osm(const fs::path& path) {
  const std::string name = path.filename().string();
  if (name.find(".osm") != std::string::npos || name.ends_with(".pbf")) return true;
  if (!name.ends_with(".json")) return false;
  std::string head(2000, '\0');  // the JSON of Overpass is no GeoJSON
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  return head.find("\"osm3s\"") != head.npos || head.find("\"elements\"") != head.npos;
}

std::map<std::string, std::string> tags_of(const OGRFeature& feature) {
  std::map<std::string, std::string> tags;
  for (int i = 0; i < feature.GetFieldCount(); ++i)
    if (feature.IsFieldSetAndNotNull(i))
      tags.emplace(feature.GetFieldDefnRef(i)->GetNameRef(), feature.GetFieldAsString(i));
  return tags;
}
}  // namespace

std::vector<Feature> read_features(const fs::path& path, const Crs& target_crs) {
  if (is_osm(path)) return read_osm_features(path, target_crs);
  const DatasetPtr dataset = open_dataset(path, GDAL_OF_VECTOR);
  const OGRSpatialReference target = spatial_reference(target_crs);
  std::vector<Feature> features;
  GdalErrors errors;
  for (OGRLayer* layer : dataset->GetLayers()) {
    if (layer->GetGeomType() == wkbNone) continue;  // a table: styles, signs
    if (!layer->GetSpatialRef())
      throw InputError(
          path.string(),
          fmt::format("layer '{}' has no coordinate reference system; say which: ogr2ogr -a_srs EPSG:n OUT IN",
                      layer->GetName()));
    OGRSpatialReference source = *layer->GetSpatialRef();
    source.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> transform(OGRCreateCoordinateTransformation(&source, &target));
    if (!transform)
      throw InputError(path.string(),
                       fmt::format("no transformation to {} ({})", target_crs.definition, errors.text()));
    for (const auto& row : *layer) {
      OGRGeometry* geometry = row->GetGeometryRef();
      if (!geometry) continue;
      if (geometry->transform(transform.get()) != OGRERR_NONE)
        throw InputError(path.string(), fmt::format("feature {} lies where {} has no coordinates", row->GetFID(),
                                                    target_crs.definition));
      Feature& feature = features.emplace_back(Feature{.tags = tags_of(*row)});
      append_geometry(feature, *geometry);
    }
  }
  if (errors.any())
    throw InputError(path.string(), fmt::format("cannot be read to its end ({}); get the file again", errors.text()));
  return features;
}

std::vector<Feature> read_features(const std::vector<fs::path>& files, const Crs& target_crs) {
  std::vector<Feature> all;
  std::unordered_map<std::string, std::size_t> known;
  for (const fs::path& file : files)
    for (Feature& feature : read_features(file, target_crs)) {
      if (!feature.osm_id.empty()) {
        const auto [at, is_new] = known.emplace(feature.osm_id, all.size());
        if (!is_new) {
          if (all[at->second].osm_version < feature.osm_version) all[at->second] = std::move(feature);
          continue;
        }
      }
      all.push_back(std::move(feature));
    }
  return all;
}

namespace {
/// A feature with parts of one kind only is a plain geometry or Multi...; anything else a collection.
std::string geometry_of(const Feature& feature, const LonLatWriter& writer) {
  std::vector<std::string> parts;
  parts.reserve(feature.polygons.size());
  for (const Polygon& polygon : feature.polygons) parts.push_back(geojson_geometry("Polygon", writer.polygon(polygon)));
  for (const Polyline& line : feature.lines) parts.push_back(geojson_geometry("LineString", writer.line(line)));
  for (const Vec2 point : feature.points) parts.push_back(geojson_geometry("Point", writer.point(point)));
  if (parts.size() == 1) return parts.front();
  if (parts.size() == feature.polygons.size() && !parts.empty()) {
    std::string text;
    for (const Polygon& polygon : feature.polygons) text += (text.empty() ? "" : ",") + writer.polygon(polygon);
    return geojson_geometry("MultiPolygon", "[" + text + "]");
  }
  return fmt::format(R"({{"type":"GeometryCollection","geometries":[{}]}})", fmt::join(parts, ","));
}
}  // namespace

void write_findings(const fs::path& path, const Findings& findings, const Crs& crs) {
  constexpr std::array severities{"info", "warning", "error"};
  const LonLatWriter writer(crs);
  std::vector<std::string> features;
  features.reserve(findings.size());
  for (const Finding& f : findings)
    features.push_back(geojson_feature(
        geojson_geometry("Point", writer.point({f.x_m, f.y_m})),
        {{"severity", severities.at(static_cast<std::size_t>(f.severity))}, {"code", f.code}, {"message", f.message}}));
  write_geojson_features(path, features);
}

void write_geojson(const fs::path& path, const std::vector<Feature>& features, const Crs& crs) {
  const LonLatWriter writer(crs);
  std::vector<std::string> texts;
  texts.reserve(features.size());
  for (const Feature& feature : features) texts.push_back(geojson_feature(geometry_of(feature, writer), feature.tags));
  write_geojson_features(path, texts);
}

}  // namespace orthodrive::io
