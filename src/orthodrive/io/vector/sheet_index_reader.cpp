// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/sheet_index_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/io/support/ogr_support.hpp"
#include "orthodrive/io/support/zip_entries.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::io {
namespace {
constexpr std::int64_t most_features = 10'000'000;

/// Of formats whose files lead on to no other file, server or view.
const std::vector<std::string> drivers_of_indices{"GeoJSON", "GeoJSONSeq",     "FlatGeobuf",  "GPKG",
                                                  "KML",     "ESRI Shapefile", "MapInfo File"};

std::string why_not(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string start(4000, '\0');
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(in.gcount()));
  const std::string text = roadquery::lowered(roadquery::trimmed(start));
  if (text.empty()) return "is empty; check the url";
  if (text.starts_with("http://") || text.starts_with("https://"))
    return "is a list of addresses that says nothing of where the sheets lie; take an index with footprints, or name "
           "the sheets of the area in 'urls' of kind \"raster\"";
  if (text.find("<html") != std::string::npos || text.starts_with("<!doctype html"))
    return "is a page of HTML and no index of sheets; check the url";
  return "";
}

DatasetPtr open_index(const std::filesystem::path& file, const std::string& shown) {
  GdalErrors errors;
  GdalOptions drivers(drivers_of_indices);
  const auto open = [&](const std::string& name) {
    return DatasetPtr(GDALDataset::Open(name.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, drivers.get()));
  };
  if (!is_zip(file)) {
    if (DatasetPtr dataset = open(file.string())) return dataset;
    const std::string why = why_not(file);
    throw InputError(shown, why.empty()
                                ? fmt::format("cannot be read as an index of sheets{}; take GeoJSON, GeoPackage, "
                                              "FlatGeobuf, KML or a shapefile",
                                              errors.any() ? " (" + printable(errors.text()) + ")" : "")
                                : why);
  }
  static constexpr std::array suffixes{".shp", ".geojson", ".json", ".gpkg", ".fgb", ".kml", ".tab", ".mif"};
  for (const std::string& entry : zip_entries(file, shown))
    if (std::any_of(suffixes.begin(), suffixes.end(),
                    [&](const char* s) { return roadquery::lowered(entry).ends_with(s); }))
      if (DatasetPtr dataset = open(entry)) return dataset;
  throw InputError(shown,
                   "is an archive without a vector file that can be read; take GeoJSON, GeoPackage or a shapefile");
}

/// Between degrees and the CRS of a layer, which may name none.
class LayerPlace {
 public:
  LayerPlace(OGRLayer& layer, const std::string& shown) : degrees_(spatial_reference(Crs{"EPSG:4326"})) {
    const OGRSpatialReference* reference = layer.GetSpatialRef();
    if (!reference) {
      OGREnvelope all;
      if (layer.GetExtent(&all, TRUE) == OGRERR_NONE &&
          (all.MinX < -181.0 || all.MaxX > 181.0 || all.MinY < -91.0 || all.MaxY > 91.0))
        throw InputError(shown, "names no CRS and its footprints are no degrees; give it one: ogr2ogr -a_srs");
      return;
    }
    own_ = *reference;
    own_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    to_degrees_.reset(OGRCreateCoordinateTransformation(&own_, &degrees_));
    from_degrees_.reset(OGRCreateCoordinateTransformation(&degrees_, &own_));
    if (!to_degrees_ || !from_degrees_) throw InputError(shown, "has a CRS that is not known here");
  }
  /// The box of a layer in which all of `box` lies; none where it cannot be told.
  [[nodiscard]] std::optional<Box2> own_box(const Box2& box) const {
    if (!from_degrees_) return box;
    Box2 result{1e300, 1e300, -1e300, -1e300};
    constexpr int steps = 8;
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; j <= steps; ++j) {
        double x = box.min_x + box.width() * i / steps, y = box.min_y + box.height() * j / steps;
        if (!from_degrees_->Transform(1, &x, &y) || !std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
        result = {std::min(result.min_x, x), std::min(result.min_y, y), std::max(result.max_x, x),
                  std::max(result.max_y, y)};
      }
    return result.grown(0.05 * std::max(result.width(), result.height()));
  }
  [[nodiscard]] std::optional<Vec2> in_degrees(double x, double y) const {
    if (to_degrees_ && !to_degrees_->Transform(1, &x, &y)) return std::nullopt;
    if (!std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
    return Vec2{x, y};
  }

 private:
  OGRSpatialReference degrees_, own_;
  std::unique_ptr<OGRCoordinateTransformation> to_degrees_, from_degrees_;
};

constexpr int most_corners = 10000;  // of a footprint; one of more is taken by its box

void add_ring(const OGRLinearRing* ring, const LayerPlace& place, MultiPolygon& into) {
  Polygon polygon;
  for (int i = 0; ring && i + 1 < ring->getNumPoints(); ++i)
    if (const auto p = place.in_degrees(ring->getX(i), ring->getY(i))) polygon.outer.push_back(*p);
  if (polygon.outer.size() >= 3) into.push_back(std::move(polygon));
}

void add_box(const OGRGeometry& geometry, const LayerPlace& place, MultiPolygon& into) {
  OGREnvelope e;
  geometry.getEnvelope(&e);
  if (!(e.MaxX > e.MinX && e.MaxY > e.MinY)) return;
  Polygon polygon;
  for (const auto& [x, y] : {std::pair{e.MinX, e.MinY}, {e.MaxX, e.MinY}, {e.MaxX, e.MaxY}, {e.MinX, e.MaxY}})
    if (const auto p = place.in_degrees(x, y)) polygon.outer.push_back(*p);
  if (polygon.outer.size() == 4) into.push_back(std::move(polygon));
}

MultiPolygon footprint_of(const OGRGeometry& geometry, const LayerPlace& place) {
  MultiPolygon footprint;
  const OGRwkbGeometryType type = wkbFlatten(geometry.getGeometryType());
  if (type == wkbPolygon && geometry.toPolygon()->getExteriorRing() &&
      geometry.toPolygon()->getExteriorRing()->getNumPoints() <= most_corners) {
    add_ring(geometry.toPolygon()->getExteriorRing(), place, footprint);
  } else if (type == wkbMultiPolygon && geometry.toMultiPolygon()->getNumGeometries() <= 100) {
    for (const OGRPolygon* part : *geometry.toMultiPolygon())
      if (part->getExteriorRing() && part->getExteriorRing()->getNumPoints() <= most_corners)
        add_ring(part->getExteriorRing(), place, footprint);
  }
  if (footprint.empty()) add_box(geometry, place, footprint);
  return footprint;
}

std::vector<std::pair<std::string, std::string>> attributes_of(OGRFeature& feature) {
  std::vector<std::pair<std::string, std::string>> attributes;
  for (int i = 0; i < std::min(feature.GetFieldCount(), 1000); ++i)
    if (feature.IsFieldSetAndNotNull(i))
      attributes.emplace_back(feature.GetFieldDefnRef(i)->GetNameRef(), feature.GetFieldAsString(i));
  return attributes;
}
}  // namespace

void visit_sheet_index(const std::filesystem::path& file, const std::string& shown, const Box2& box,
                       const std::function<void(IndexedSheet&&)>& take) {
  start_gdal();
  const DatasetPtr index = open_index(file, shown);
  GdalErrors errors;
  std::int64_t features = 0;
  bool any_footprint = false;
  for (OGRLayer* layer : index->GetLayers()) {
    if (layer->GetGeomType() == wkbNone) continue;
    const LayerPlace place(*layer, shown);
    any_footprint = any_footprint || layer->GetFeatureCount(FALSE) != 0;
    if (const auto own = place.own_box(box))
      layer->SetSpatialFilterRect(own->min_x, own->min_y, own->max_x, own->max_y);
    while (const OGRFeatureUniquePtr feature{layer->GetNextFeature()}) {
      if (++features > most_features)
        throw InputError(shown, fmt::format("has more than {} features, which is not read", most_features));
      if (features % 1000 == 0) throw_if_stopped();
      const OGRGeometry* geometry = feature->GetGeometryRef();
      if (!geometry) continue;
      IndexedSheet sheet{footprint_of(*geometry, place), {}};
      if (sheet.footprint.empty() || !bounds_of_all(sheet.footprint).overlaps(box)) continue;
      sheet.attributes = attributes_of(*feature);
      take(std::move(sheet));
    }
  }
  if (errors.any()) throw InputError(shown, fmt::format("is damaged ({}); get it again", printable(errors.text())));
  if (!any_footprint) throw InputError(shown, "has no feature with a footprint; take an index of polygons");
}

}  // namespace orthodrive::io
