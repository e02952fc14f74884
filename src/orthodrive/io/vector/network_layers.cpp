// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/network_layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/geojson_support.hpp"
#include "orthodrive/io/support/ogr_support.hpp"
#include "roadquery/map/lane_type_name.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::io {
namespace {

using roadquery::Lane;
using roadquery::LaneSection;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double tolerance_m = 0.02, min_step_m = 0.5, max_step_m = 10.0;
constexpr double min_lane_width_m = 0.01, min_part_area_m2 = 0.01;

struct Value {
  const char* name;
  OGRFieldType type;
  nlohmann::json value;  ///< null: not known
};
struct LayerRow {
  Polyline line;                ///< of reference lines
  std::vector<double> heights;  ///< of the line's points
  MultiPolygon polygons;
  std::vector<Value> values;
};
struct Layer {
  const char* name;
  OGRwkbGeometryType type;
  std::vector<LayerRow> rows;
};

/// Places from s0 to s1 between which chords stay within the tolerance of a line that bends as the reference line does.
std::vector<double> places(const Road& road, double s0, double s1) {
  std::vector<double> fixed{s0, s1};
  for (const roadquery::PlanElement& e : road.plan)
    if (e.s > s0 && e.s < s1) fixed.push_back(e.s);
  std::sort(fixed.begin(), fixed.end());
  std::vector<double> result{s0};
  for (std::size_t i = 1; i < fixed.size(); ++i) {
    for (double s = fixed[i - 1]; s < fixed[i];) {
      const double bend =
          std::max(std::abs(roadquery::reference_point(road, s).curvature),
                   std::abs(roadquery::reference_point(road, std::min(s + min_step_m, fixed[i])).curvature));
      s += bend > 0.0 ? std::clamp(std::sqrt(8.0 * tolerance_m / bend), min_step_m, max_step_m) : max_step_m;
      if (s < fixed[i] - 0.1 * min_step_m) result.push_back(s);
    }
    if (fixed[i] > result.back()) result.push_back(fixed[i]);
  }
  return result;
}

LayerRow reference_line(const Road& road) {
  LayerRow row;
  for (const double s : places(road, 0.0, road.length)) {
    const roadquery::PlanPoint p = roadquery::reference_point(road, s);
    row.line.push_back({p.x, p.y});
    row.heights.push_back(roadquery::elevation(road, s));
  }
  const nlohmann::json speed =
      road.speed_limit_mps > 0.0 ? nlohmann::json(std::round(road.speed_limit_mps * 36.0) / 10.0) : nlohmann::json();
  row.values = {{"road", OFTInteger, road.id},
                {"junction", OFTInteger, road.junction},
                {"osm_id", OFTString, road.osm_id},
                {"name", OFTString, road.name},
                {"highway", OFTString, road.highway},
                {"length_m", OFTReal, std::round(road.length * 1e3) / 1e3},
                {"speed_kmh", OFTReal, speed},
                {"layer", OFTInteger, road.layer},
                {"bridge", OFTInteger, int{road.bridge}},
                {"tunnel", OFTInteger, int{road.tunnel}}};
  return row;
}

/// Borders of the lanes of one side, from the inside out, at the places of a section.
class SideBorders {
 public:
  SideBorders(const Road& road, const LaneSection& section, double end, bool left)
      : road_(road), section_(section), s_(places(road, section.s, end)), sign_(left ? 1.0 : -1.0) {
    for (double& s : s_) s = std::min(s, end - 1e-9);  // the end belongs to the next section
    for (const double s : s_) t_.push_back(roadquery::evaluate(road.lane_offset, s));
  }

  /// The next lane outwards: its polygon, or none where it is nowhere wide enough.
  std::optional<MultiPolygon> next(const Lane& lane) {
    std::vector<double> outer = t_;
    double widest = 0.0;
    for (std::size_t i = 0; i < s_.size(); ++i) {
      const double width = std::max(0.0, roadquery::lane_width(lane, s_[i] - section_.s));
      outer[i] += sign_ * width;
      widest = std::max(widest, width);
    }
    t_.swap(outer);  // now `outer` holds the inner border
    if (widest < min_lane_width_m) return std::nullopt;
    Ring ring;
    for (std::size_t i = 0; i < s_.size(); ++i) ring.push_back(point(s_[i], outer[i]));
    for (std::size_t i = s_.size(); i-- > 0;) ring.push_back(point(s_[i], t_[i]));
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return MultiPolygon{valid({std::move(ring), {}}, outer)};
  }

 private:
  [[nodiscard]] Vec2 point(double s, double t) const {
    const roadquery::SurfacePoint p = roadquery::surface_point(road_, s, t);
    return {p.x, p.y};
  }

  /// Where a tight bend folds the ring over itself, the union of its cells.
  [[nodiscard]] MultiPolygon valid(Polygon polygon, const std::vector<double>& inner) const {
    if (to_ogr(polygon)->IsValid()) return {std::move(polygon)};
    OGRMultiPolygon cells;
    for (std::size_t i = 1; i < s_.size(); ++i) {
      const Ring cell = convex_hull(
          {point(s_[i - 1], inner[i - 1]), point(s_[i], inner[i]), point(s_[i], t_[i]), point(s_[i - 1], t_[i - 1])});
      if (cell.size() > 2) cells.addGeometryDirectly(to_ogr(Polygon{cell, {}}).release());
    }
    const std::unique_ptr<OGRGeometry> whole(cells.UnionCascaded());
    Feature feature;
    if (whole) append_geometry(feature, *whole);
    // Slivers between the cells, which no longer are areas once a file rounds them.
    const auto is_sliver = [](const Ring& ring) { return std::abs(signed_area_m2(ring)) < min_part_area_m2; };
    std::erase_if(feature.polygons, [&](const Polygon& part) { return is_sliver(part.outer); });
    for (Polygon& part : feature.polygons) std::erase_if(part.holes, is_sliver);
    return feature.polygons.empty() ? MultiPolygon{std::move(polygon)} : std::move(feature.polygons);
  }

  const Road& road_;
  const LaneSection& section_;
  std::vector<double> s_, t_;
  double sign_;
};

/// Of the start of the section.
nlohmann::json surface_name(const Lane& lane) {
  return lane.materials.empty() ? nlohmann::json() : nlohmann::json(roadquery::to_string(lane.materials[0].surface));
}

void add_lanes(const Road& road, std::vector<LayerRow>& rows) {
  for (std::size_t k = 0; k < road.sections.size(); ++k) {
    const LaneSection& section = road.sections[k];
    const double end = k + 1 < road.sections.size() ? road.sections[k + 1].s : road.length;
    if (!(end > section.s)) continue;
    for (const auto* side : {&section.left, &section.right}) {
      if (side->empty()) continue;
      SideBorders borders(road, section, end, side == &section.left);
      for (const Lane& lane : *side) {
        std::optional<MultiPolygon> polygons = borders.next(lane);
        if (!polygons) continue;
        rows.push_back({{},
                        {},
                        std::move(*polygons),
                        {{"road", OFTInteger, road.id},
                         {"section", OFTInteger, static_cast<int>(k)},
                         {"lane", OFTInteger, lane.id},
                         {"type", OFTString, roadquery::lane_type_name(lane.type)},
                         {"junction", OFTInteger, road.junction},
                         {"osm_id", OFTString, road.osm_id},
                         {"surface", OFTString, surface_name(lane)},
                         {"friction", OFTReal,
                          lane.materials.empty() ? nlohmann::json() : nlohmann::json(lane.materials[0].friction)}}});
      }
    }
  }
}

std::vector<LayerRow> junction_rows(const RoadMap& map, const std::vector<LayerRow>& lanes) {
  std::map<int, std::vector<Vec2>> points;  // of the lanes of every junction's connecting roads
  for (const LayerRow& lane : lanes)
    if (const int junction = lane.values[4].value.get<int>(); junction >= 0)
      for (const Polygon& polygon : lane.polygons)
        points[junction].insert(points[junction].end(), polygon.outer.begin(), polygon.outer.end());
  std::vector<LayerRow> rows;
  for (const roadquery::Junction& junction : map.junctions) {
    Ring hull = convex_hull(points[junction.id]);
    if (hull.size() < 3) continue;
    std::set<int> incoming;
    for (const roadquery::Connection& c : junction.connections) incoming.insert(c.incoming_road);
    rows.push_back({{},
                    {},
                    {Polygon{std::move(hull), {}}},
                    {{"junction", OFTInteger, junction.id},
                     {"connections", OFTInteger, static_cast<int>(junction.connections.size())},
                     {"roads", OFTInteger, static_cast<int>(incoming.size())}}});
  }
  return rows;
}

std::vector<Layer> layers_of(const RoadMap& map, const std::filesystem::path& path) {
  if (map.geo_reference.empty())
    throw InputError(path.string(), "the network has no geoReference, so nobody knows where on Earth it lies");
  Layer lines{"reference_lines", wkbLineString25D, {}}, lanes{"lanes", wkbUnknown, {}},
      junctions{"junctions", wkbPolygon, {}};
  for (const Road& road : map.roads) {
    lines.rows.push_back(reference_line(road));
    add_lanes(road, lanes.rows);
  }
  junctions.rows = junction_rows(map, lanes.rows);
  return {std::move(lines), std::move(lanes), std::move(junctions)};
}

std::unique_ptr<OGRGeometry> geometry_of(const LayerRow& row) {
  if (!row.line.empty()) {
    std::unique_ptr<OGRLineString> line = std::make_unique<OGRLineString>();
    for (std::size_t i = 0; i < row.line.size(); ++i) line->addPoint(row.line[i].x, row.line[i].y, row.heights[i]);
    return line;
  }
  if (row.polygons.size() == 1) return to_ogr(row.polygons.front());
  auto several = std::make_unique<OGRMultiPolygon>();
  for (const Polygon& polygon : row.polygons) several->addGeometryDirectly(to_ogr(polygon).release());
  return several;
}

void set_field(OGRFeature& feature, const Value& v) {
  if (v.value.is_null()) return;
  switch (v.type) {
    case OFTInteger:
      return feature.SetField(v.name, v.value.get<int>());
    case OFTReal:
      return feature.SetField(v.name, v.value.get<double>());
    default:
      return feature.SetField(v.name, v.value.get_ref<const std::string&>().c_str());
  }
}

}  // namespace

namespace {

/// The EPSG's name for a CRS that is a PROJ string, where it has one: QGIS and others show it instead of "unknown".
OGRSpatialReference with_short_name(const OGRSpatialReference& reference) {
  constexpr int least_confidence = 70;  // of 100, PROJ: equivalent but for the names
  OGRSpatialReference* const match = reference.FindBestMatch(least_confidence);
  if (!match) return reference;
  OGRSpatialReference result = *match;
  match->Release();
  result.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return result;
}

}  // namespace

void write_network_layers(const std::filesystem::path& path, const RoadMap& map) {
  const std::vector<Layer> layers = layers_of(map, path);
  write_geopackage(path, [&](GDALDataset& dataset, const GdalErrors& errors) {
    OGRSpatialReference reference = with_short_name(spatial_reference({map.geo_reference}));
    for (const Layer& layer : layers) {
      OGRLayer* made = dataset.CreateLayer(layer.name, &reference, layer.type, nullptr);
      if (!made) throw Error(fmt::format("layer '{}' cannot be made, is the disk full?", layer.name));
      if (layer.rows.empty()) continue;
      for (const Value& v : layer.rows.front().values) create_field(*made, v.name, v.type);
      for (const LayerRow& row : layer.rows) {
        OGRFeature feature(made->GetLayerDefn());
        for (const Value& v : row.values) set_field(feature, v);
        feature.SetGeometryDirectly(geometry_of(row).release());
        add_feature(*made, feature, path.string(), errors);
      }
    }
  });
}

void write_network_geojson(const std::filesystem::path& path, const RoadMap& map) {
  const std::vector<Layer> layers = layers_of(map, path);
  const LonLatWriter writer(Crs{map.geo_reference}, 9);
  std::vector<std::string> features;
  for (const Layer& layer : layers)
    for (const LayerRow& row : layer.rows) {
      nlohmann::json properties{{"layer_name", layer.name}};
      for (const Value& v : row.values) properties[v.name] = v.value;
      std::string geometry;
      if (!row.line.empty()) {
        geometry = geojson_geometry("LineString", writer.line(row.line));
      } else if (row.polygons.size() == 1) {
        geometry = geojson_geometry("Polygon", writer.polygon(row.polygons.front()));
      } else {
        std::string parts;
        for (const Polygon& polygon : row.polygons) parts += (parts.empty() ? "" : ",") + writer.polygon(polygon);
        geometry = geojson_geometry("MultiPolygon", "[" + parts + "]");
      }
      features.push_back(geojson_feature(geometry, properties));
    }
  write_geojson_features(path, features);
}

}  // namespace orthodrive::io
