// SPDX-License-Identifier: Apache-2.0
#pragma once
// Our values as OGR geometries and back. Internal to io.

#include <ogrsf_frmts.h>

#include <filesystem>
#include <functional>
#include <memory>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {

[[nodiscard]] std::unique_ptr<OGRLineString> to_ogr(const Polyline& line);
[[nodiscard]] std::unique_ptr<OGRPolygon> to_ogr(const Polygon& polygon);

/// Appends the parts of any geometry to the feature; curves become lines.
void append_geometry(Feature& feature, const OGRGeometry& geometry);

/// A layer's fields in a row: makes the definition once, so that writing cannot name a field twice or differently.
void create_field(OGRLayer& layer, const char* name, OGRFieldType type);
void add_feature(OGRLayer& layer, OGRFeature& feature, const std::string& file, const GdalErrors& errors);

/// A new GeoPackage that `fill` gives its layers, written aside in one transaction. Throws Error naming the file.
void write_geopackage(const std::filesystem::path& path,
                      const std::function<void(GDALDataset& dataset, const GdalErrors& errors)>& fill);

}  // namespace orthodrive::io
