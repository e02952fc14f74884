// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/qgis_style.hpp"

#include <fmt/format.h>

#include "orthodrive/core/escape_xml.hpp"

namespace orthodrive::io {
namespace {

constexpr const char* head =
    "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
    "<qgis version=\"3.22.16\" styleCategories=\"Symbology\">\n";

using Color = std::array<std::uint8_t, 3>;

struct RoadClass {
  const char* highway;
  Color color;
  double width_mm;
};
/// As OSM's own map colours them; links follow their roads.
constexpr RoadClass road_classes[] = {{"motorway", {232, 146, 162}, 1.0},      {"motorway_link", {232, 146, 162}, 0.7},
                                      {"trunk", {249, 178, 156}, 0.9},         {"trunk_link", {249, 178, 156}, 0.6},
                                      {"primary", {252, 214, 164}, 0.8},       {"primary_link", {252, 214, 164}, 0.6},
                                      {"secondary", {240, 240, 160}, 0.7},     {"secondary_link", {240, 240, 160}, 0.5},
                                      {"tertiary", {220, 220, 220}, 0.6},      {"tertiary_link", {220, 220, 220}, 0.5},
                                      {"unclassified", {190, 190, 190}, 0.5},  {"residential", {170, 170, 170}, 0.5},
                                      {"living_street", {150, 150, 150}, 0.4}, {"service", {130, 130, 130}, 0.3},
                                      {"track", {172, 131, 39}, 0.3},          {"raceway", {255, 120, 200}, 0.8}};

std::string option(const char* name, const std::string& value) {
  return fmt::format("<Option name=\"{}\" type=\"QString\" value=\"{}\"/>", name, escape_xml(value));
}

std::string rgba(const Color& c) { return fmt::format("{},{},{},255", c[0], c[1], c[2]); }

std::string symbol_layer(QgisSymbol symbol, const QgisCategory& category) {
  const std::string size = fmt::format("{:g}", category.size_mm), color = rgba(category.color);
  std::string name, options;
  switch (symbol) {
    case QgisSymbol::point:
      name = "SimpleMarker";
      options = option("name", "circle") + option("color", color) + option("outline_color", "35,35,35,255") +
                option("outline_width", "0.2") + option("size", size) + option("size_unit", "MM");
      break;
    case QgisSymbol::line:
      name = "SimpleLine";
      options = option("line_color", color) + option("line_width", size) + option("line_width_unit", "MM") +
                option("capstyle", "round") + option("joinstyle", "round");
      break;
    case QgisSymbol::polygon:
      name = "SimpleFill";
      options = option("color", color) + option("style", "solid") + option("outline_color", "90,90,90,255") +
                option("outline_width", size) + option("outline_width_unit", "MM");
      break;
  }
  return fmt::format(
      "<layer class=\"{}\" enabled=\"1\" locked=\"0\" pass=\"0\"><Option type=\"Map\">{}</Option></layer>", name,
      options);
}

std::vector<QgisCategory> road_categories(double border_mm) {
  std::vector<QgisCategory> categories;
  categories.reserve(std::size(road_classes));
  for (const RoadClass& entry : road_classes)
    categories.push_back({entry.highway, entry.highway, entry.color, border_mm > 0.0 ? border_mm : entry.width_mm});
  categories.push_back({"", "other", {120, 120, 120}, border_mm > 0.0 ? border_mm : 0.3});
  return categories;
}

}  // namespace

std::string qgis_label_style(const ClassTable& classes) {
  std::string entries;
  for (std::size_t i = 0; i < classes.classes.size(); ++i) {
    const ClassInfo& info = classes.classes[i];
    entries +=
        fmt::format("    <paletteEntry value=\"{}\" color=\"#{:02x}{:02x}{:02x}\" alpha=\"255\" label=\"{}\"/>\n", i,
                    info.color[0], info.color[1], info.color[2], escape_xml(info.name));
  }
  return std::string(head) +
         " <pipe>\n  <rasterrenderer type=\"paletted\" band=\"1\" opacity=\"1\" alphaBand=\"-1\" nodataColor=\"\">\n"
         "   <colorPalette>\n" +
         entries + "   </colorPalette>\n  </rasterrenderer>\n </pipe>\n <blendMode>0</blendMode>\n</qgis>\n";
}

std::string qgis_category_style(QgisSymbol symbol, const std::string& field,
                                const std::vector<QgisCategory>& categories) {
  constexpr const char* types[] = {"marker", "line", "fill"};
  std::string entries, symbols;
  for (std::size_t i = 0; i < categories.size(); ++i) {
    entries += fmt::format("   <category value=\"{}\" label=\"{}\" symbol=\"{}\" render=\"true\"/>\n",
                           escape_xml(categories[i].value), escape_xml(categories[i].label), i);
    symbols += fmt::format("   <symbol type=\"{}\" name=\"{}\" alpha=\"1\" clip_to_extent=\"1\">{}</symbol>\n",
                           types[static_cast<int>(symbol)], i, symbol_layer(symbol, categories[i]));
  }
  return fmt::format(
      "{} <renderer-v2 type=\"categorizedSymbol\" attr=\"{}\" symbollevels=\"0\" enableorderby=\"0\" "
      "forceraster=\"0\">\n  <categories>\n{}  </categories>\n  <symbols>\n{}  </symbols>\n </renderer-v2>\n"
      " <blendMode>0</blendMode>\n</qgis>\n",
      head, escape_xml(field), entries, symbols);
}

std::string qgis_road_style(const std::string& layer) {
  if (layer == "centrelines") return qgis_category_style(QgisSymbol::line, "highway", road_categories(0.0));
  if (layer == "surface") return qgis_category_style(QgisSymbol::polygon, "highway", road_categories(0.1));
  return {};
}

std::string qgis_findings_style() {
  return qgis_category_style(QgisSymbol::point, "severity",
                             {{"error", "error", {215, 25, 28}, 4.0},
                              {"warning", "warning", {253, 174, 97}, 3.0},
                              {"info", "info", {44, 123, 182}, 2.0}});
}

std::string qgis_road_graph_style() {
  return qgis_category_style(
      QgisSymbol::line, "state",
      {{"before", "before: OSM", {215, 25, 28}, 0.3}, {"after", "after: refined", {26, 150, 65}, 0.5}});
}

}  // namespace orthodrive::io
