// SPDX-License-Identifier: Apache-2.0
// Layers of a GeoPackage to look at.

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/ogr_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
std::unique_ptr<OGRGeometry> geometry_of(const NumberLayer::Geometry& geometry) {
  if (const auto* polygon = std::get_if<Polygon>(&geometry)) return to_ogr(*polygon);
  if (const auto* line = std::get_if<Polyline>(&geometry)) return to_ogr(*line);
  const Vec2 p = std::get<Vec2>(geometry);
  return std::make_unique<OGRPoint>(p.x, p.y);
}

void add_layer(GDALDataset& dataset, OGRSpatialReference& reference, const NumberLayer& layer, const std::string& file,
               const GdalErrors& errors) {
  OGRLayer* made = dataset.CreateLayer(layer.name.c_str(), &reference, wkbUnknown, nullptr);
  if (!made) throw Error(fmt::format("layer '{}' cannot be made, is the disk full?", layer.name));
  for (const std::string& field : layer.fields) create_field(*made, field.c_str(), OFTReal);
  for (const NumberLayer::Row& row : layer.rows) {
    assert(row.numbers.size() == layer.fields.size());
    OGRFeature feature(made->GetLayerDefn());
    for (std::size_t i = 0; i < row.numbers.size(); ++i)
      if (!std::isnan(row.numbers[i])) feature.SetField(layer.fields[i].c_str(), row.numbers[i]);
    feature.SetGeometryDirectly(geometry_of(row.geometry).release());
    add_feature(*made, feature, file, errors);
  }
}
}  // namespace

void write_layers(const fs::path& path, const std::vector<NumberLayer>& layers, const Crs& crs) {
  write_geopackage(path, [&](GDALDataset& dataset, const GdalErrors& errors) {
    OGRSpatialReference reference = spatial_reference(crs);
    for (const NumberLayer& layer : layers) add_layer(dataset, reference, layer, path.string(), errors);
  });
}

}  // namespace orthodrive::io
