// SPDX-License-Identifier: Apache-2.0
#pragma once
// Styles for QGIS (QML, as QGIS 3.22 writes it): what the outputs look like when they are dropped into a map.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive::io {

/// Features whose field has the value are drawn in this colour; the empty value stands for all others.
struct QgisCategory {
  std::string value, label;
  std::array<std::uint8_t, 3> color{};
  double size_mm = 0.0;  ///< width of a line, diameter of a point; of polygons the width of their border
};
enum class QgisSymbol : std::uint8_t { point, line, polygon };

/// A raster of labels: a colour and a name a class, in the order of the table.
[[nodiscard]] std::string qgis_label_style(const ClassTable& classes);
/// A vector layer, told apart by the text in one field.
[[nodiscard]] std::string qgis_category_style(QgisSymbol symbol, const std::string& field,
                                              const std::vector<QgisCategory>& categories);

/// Layers of roads.gpkg: centre lines and surfaces by `highway`. Empty for other layers.
[[nodiscard]] std::string qgis_road_style(const std::string& layer);
/// findings.geojson by `severity`, and road_graph.geojson by `state`.
[[nodiscard]] std::string qgis_findings_style();
[[nodiscard]] std::string qgis_road_graph_style();

}  // namespace orthodrive::io
