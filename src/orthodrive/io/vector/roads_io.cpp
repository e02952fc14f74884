// SPDX-License-Identifier: Apache-2.0
// roads.gpkg: layers centrelines, nodes and surface, tables restrictions and signs. The nodes are the truth; lines and
// polygons are made from them for people and for other tools, and carry the attributes of the way.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <tuple>
#include <utility>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/median.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/support/ogr_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/vector/qgis_style.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

namespace {
struct Field {
  const char* name;
  OGRFieldType type;
};
constexpr Field centreline_fields[] = {{"osm_id", OFTInteger64}, {"part", OFTInteger},      {"highway", OFTString},
                                       {"name", OFTString},      {"layer", OFTInteger},     {"bridge", OFTInteger},
                                       {"tunnel", OFTInteger},   {"oneway", OFTInteger},    {"lanes", OFTInteger},
                                       {"width_m", OFTReal},     {"roundabout", OFTInteger}};
// Not in files of older versions: read where they are.
constexpr Field lane_fields[] = {{"lanes_forward", OFTInteger}, {"lanes_backward", OFTInteger},
                                 {"turn_forward", OFTString},   {"turn_backward", OFTString},
                                 {"speed_limit_kmh", OFTReal},  {"sidewalk", OFTInteger},
                                 {"shoulder", OFTInteger},      {"surface", OFTString}};
// Nor these.
constexpr Field use_fields[] = {{"lanes_both_ways", OFTInteger},     {"use_forward", OFTString},
                                {"use_backward", OFTString},         {"use", OFTString},
                                {"side_lanes", OFTString},           {"speeds_forward", OFTString},
                                {"speeds_backward", OFTString},      {"placement_start", OFTReal},
                                {"placement_end", OFTReal},          {"placement_backward", OFTInteger},
                                {"placement_transition", OFTInteger}};
// Nor these.
constexpr Field text_fields[] = {{"speed_context", OFTString},
                                 {"traffic_calming", OFTString},
                                 {"widths_forward", OFTString},
                                 {"widths_backward", OFTString},
                                 {"widths_both_ways", OFTString}};
// Not in files of older versions either: then the tags that are in them tell.
constexpr Field class_fields[] = {{"surface_class", OFTString}, {"surface_source", OFTString}};
constexpr Field restriction_fields[] = {
    {"from_way", OFTInteger64}, {"via_node", OFTInteger64}, {"to_way", OFTInteger64}, {"only", OFTInteger}};
constexpr Field later_restriction_field = {"via_ways", OFTString};  // "7 8"; older files lack it
constexpr Field sign_fields[] = {{"osm_node", OFTInteger64}, {"kind", OFTString}, {"direction", OFTInteger},
                                 {"value", OFTString},       {"size_m", OFTReal}, {"closed", OFTInteger}};
constexpr Field old_sign_fields[] = {{"osm_node", OFTInteger64}, {"kind", OFTString}, {"direction", OFTInteger}};
constexpr Field node_fields[] = {{"osm_id", OFTInteger64},
                                 {"part", OFTInteger},
                                 {"osm_node", OFTInteger64},
                                 {"s_m", OFTReal},
                                 {"offset_m", OFTReal},
                                 {"width_m", OFTReal},
                                 {"sigma_offset_m", OFTReal},
                                 {"sigma_width_m", OFTReal},
                                 {"z_m", OFTReal},
                                 {"gradient", OFTReal},
                                 {"banking", OFTReal},
                                 {"sigma_z_m", OFTReal},
                                 {"banking_source", OFTString}};
constexpr Field later_node_fields[] = {
    {"crown", OFTReal}, {"sigma_banking", OFTReal}, {"kerb_radius_m", OFTReal}};  // older files lack them
constexpr Field surface_fields[] = {
    {"osm_id", OFTInteger64}, {"part", OFTInteger}, {"highway", OFTString}, {"layer", OFTInteger}};
constexpr Field roughness_fields[] = {{"osm_id", OFTInteger64}, {"part", OFTInteger},          {"s_begin_m", OFTReal},
                                      {"s_end_m", OFTReal},     {"iso_8608_class", OFTString}, {"gd_n0_m3", OFTReal},
                                      {"waviness", OFTReal},    {"sigma_ln_gd", OFTReal}};

/// `reference`: nullptr for a table without places.
template <std::size_t n>
OGRLayer& create_layer(GDALDataset& dataset, const char* name, OGRwkbGeometryType type, OGRSpatialReference* reference,
                       const Field (&fields)[n]) {
  OGRLayer* layer = dataset.CreateLayer(name, reference, type, nullptr);
  if (!layer) throw Error(fmt::format("layer '{}' cannot be made, is the disk full?", name));
  for (const Field& field : fields) create_field(*layer, field.name, field.type);
  return *layer;
}

double median_width_m(const RoadPath& path) {
  std::vector<double> widths;
  widths.reserve(path.nodes.size());
  for (const RoadNode& node : path.nodes) widths.push_back(node.width_m);
  if (widths.empty()) return 0.0;
  return median(std::move(widths));
}

/// One valid geometry: where a tight bend folds the strip over itself, the union of its cells.
std::unique_ptr<OGRGeometry> surface_of(const RoadPath& path) {
  std::unique_ptr<OGRGeometry> strip = to_ogr(Polygon{surface_ring(path), {}});
  if (strip->IsValid()) return strip;
  OGRMultiPolygon cells;
  for (const Ring& cell : surface_cells(path)) cells.addGeometryDirectly(to_ogr(Polygon{cell, {}}).release());
  return std::unique_ptr<OGRGeometry>(cells.UnionCascaded());
}

class RoadsWriter {
 public:
  RoadsWriter(GDALDataset& dataset, OGRSpatialReference& reference, std::string file, const GdalErrors& errors)
      : centrelines_(create_layer(dataset, "centrelines", wkbLineString, &reference, centreline_fields)),
        nodes_(create_layer(dataset, "nodes", wkbPoint, &reference, node_fields)),
        surface_(create_layer(dataset, "surface", wkbUnknown, &reference, surface_fields)),
        file_(std::move(file)),
        errors_(errors) {
    for (const Field& field : later_node_fields) create_field(nodes_, field.name, field.type);
    for (const Field& field : lane_fields) create_field(centrelines_, field.name, field.type);
    for (const Field& field : use_fields) create_field(centrelines_, field.name, field.type);
    for (const Field& field : text_fields) create_field(centrelines_, field.name, field.type);
    for (const Field& field : class_fields) create_field(centrelines_, field.name, field.type);
  }

  void add(const RoadPath& path) {
    add_centreline(path);
    for (const RoadNode& node : path.nodes) add_node(path, node);
    add_surface(path);
  }

 private:
  void add_centreline(const RoadPath& path) {
    OGRFeature row(centrelines_.GetLayerDefn());
    row.SetField("osm_id", static_cast<GIntBig>(path.osm_id));
    row.SetField("part", path.part);
    row.SetField("highway", path.highway.c_str());
    row.SetField("name", path.name.c_str());
    row.SetField("layer", path.layer);
    row.SetField("bridge", path.bridge ? 1 : 0);
    row.SetField("tunnel", path.tunnel ? 1 : 0);
    row.SetField("oneway", static_cast<int>(path.oneway));
    row.SetField("lanes", path.lanes);
    row.SetField("width_m", median_width_m(path));
    row.SetField("roundabout", path.roundabout ? 1 : 0);
    row.SetField("lanes_forward", path.lanes_forward);
    row.SetField("lanes_backward", path.lanes_backward);
    row.SetField("turn_forward", path.turn_forward.c_str());
    row.SetField("turn_backward", path.turn_backward.c_str());
    row.SetField("speed_limit_kmh", path.speed_limit_kmh);
    row.SetField("speed_context", path.speed_context.c_str());
    row.SetField("sidewalk", static_cast<int>(path.sidewalk));
    row.SetField("shoulder", static_cast<int>(path.shoulder));
    row.SetField("surface", path.surface.c_str());
    row.SetField("surface_class", roadquery::to_string(path.known_surface.surface));
    row.SetField("surface_source", to_string(path.known_surface.source));
    set_uses(row, path);
    row.SetGeometryDirectly(to_ogr(centerline(path)).release());
    add_feature(centrelines_, row, file_, errors_);
  }
  static void set_uses(OGRFeature& row, const RoadPath& path) {
    row.SetField("traffic_calming", path.traffic_calming.c_str());
    row.SetField("lanes_both_ways", path.lanes_both_ways);
    row.SetField("use_forward", path.use_forward.c_str());
    row.SetField("use_backward", path.use_backward.c_str());
    row.SetField("use", path.use.c_str());
    row.SetField("side_lanes", path.side_lanes.c_str());
    row.SetField("speeds_forward", path.speeds_forward.c_str());
    row.SetField("speeds_backward", path.speeds_backward.c_str());
    row.SetField("widths_forward", path.widths_forward.c_str());
    row.SetField("widths_backward", path.widths_backward.c_str());
    row.SetField("widths_both_ways", path.widths_both_ways.c_str());
    const auto& placement = path.placement;
    if (placement.start >= 0.0) row.SetField("placement_start", placement.start);
    if (placement.end >= 0.0) row.SetField("placement_end", placement.end);
    row.SetField("placement_backward", placement.backward ? 1 : 0);
    row.SetField("placement_transition", placement.transition ? 1 : 0);
  }
  void add_node(const RoadPath& path, const RoadNode& node) {
    OGRFeature row(nodes_.GetLayerDefn());
    row.SetField("osm_id", static_cast<GIntBig>(path.osm_id));
    row.SetField("part", path.part);
    row.SetField("osm_node", static_cast<GIntBig>(node.osm_node));
    row.SetField("s_m", node.s_m);
    row.SetField("offset_m", node.offset_m);
    row.SetField("width_m", node.width_m);
    row.SetField("sigma_offset_m", node.sigma_offset_m);
    row.SetField("sigma_width_m", node.sigma_width_m);
    if (!std::isnan(node.z_m)) row.SetField("z_m", node.z_m);  // null before the stage elevate
    row.SetField("gradient", node.gradient);
    row.SetField("banking", node.banking);
    row.SetField("sigma_z_m", node.sigma_z_m);
    row.SetField("banking_source", to_string(node.banking_source));
    row.SetField("crown", node.crown);
    row.SetField("sigma_banking", node.sigma_banking);
    if (node.kerb_radius_m > 0.0) row.SetField("kerb_radius_m", node.kerb_radius_m);
    OGRPoint point(node.p.x, node.p.y);
    row.SetGeometry(&point);
    add_feature(nodes_, row, file_, errors_);
  }
  void add_surface(const RoadPath& path) {
    OGRFeature row(surface_.GetLayerDefn());
    row.SetField("osm_id", static_cast<GIntBig>(path.osm_id));
    row.SetField("part", path.part);
    row.SetField("highway", path.highway.c_str());
    row.SetField("layer", path.layer);
    row.SetGeometryDirectly(surface_of(path).release());
    add_feature(surface_, row, file_, errors_);
  }

  OGRLayer &centrelines_, &nodes_, &surface_;
  std::string file_;
  const GdalErrors& errors_;
};
}  // namespace

namespace {
/// The centre line of every stretch, to look at, with its numbers.
void write_roughness(GDALDataset& dataset, OGRSpatialReference& reference, const RoadNetwork& roads,
                     const std::vector<RoughnessStretch>& roughness, const std::string& file,
                     const GdalErrors& errors) {
  std::map<std::pair<std::int64_t, int>, const RoadPath*> path_of;
  for (const RoadPath& path : roads.paths) path_of[{path.osm_id, path.part}] = &path;
  OGRLayer& layer = create_layer(dataset, "roughness", wkbLineString, &reference, roughness_fields);
  for (const RoughnessStretch& stretch : roughness) {
    OGRFeature row(layer.GetLayerDefn());
    row.SetField("osm_id", static_cast<GIntBig>(stretch.osm_id));
    row.SetField("part", stretch.part);
    row.SetField("s_begin_m", stretch.s_begin_m);
    row.SetField("s_end_m", stretch.s_end_m);
    row.SetField("iso_8608_class", std::string(1, stretch.iso_8608_class).c_str());
    row.SetField("gd_n0_m3", stretch.gd_n0_m3);
    row.SetField("waviness", stretch.waviness);
    row.SetField("sigma_ln_gd", stretch.sigma_ln_gd);
    Polyline line;
    const auto at = path_of.find({stretch.osm_id, stretch.part});
    if (at == path_of.end())
      throw Error(
          fmt::format("{}: roughness of way {} part {}, which is not there", file, stretch.osm_id, stretch.part));
    const Polyline whole = centerline(*at->second);
    line.push_back(point_at(whole, stretch.s_begin_m));
    for (const RoadNode& node : at->second->nodes)
      if (node.s_m > stretch.s_begin_m && node.s_m < stretch.s_end_m) line.push_back(node.p);
    line.push_back(point_at(whole, stretch.s_end_m));
    row.SetGeometryDirectly(to_ogr(line).release());
    add_feature(layer, row, file, errors);
  }
}

/// Table without places; only there when there are any.
void write_restrictions(GDALDataset& dataset, const std::vector<TurnRestriction>& restrictions, const std::string& file,
                        const GdalErrors& errors) {
  if (restrictions.empty()) return;
  OGRLayer& layer = create_layer(dataset, "restrictions", wkbNone, nullptr, restriction_fields);
  create_field(layer, later_restriction_field.name, later_restriction_field.type);
  for (const TurnRestriction& restriction : restrictions) {
    OGRFeature row(layer.GetLayerDefn());
    row.SetField("from_way", static_cast<GIntBig>(restriction.from_way));
    row.SetField("via_node", static_cast<GIntBig>(restriction.via_node));
    row.SetField("to_way", static_cast<GIntBig>(restriction.to_way));
    row.SetField("only", restriction.only ? 1 : 0);
    row.SetField(later_restriction_field.name, fmt::format("{}", fmt::join(restriction.via_ways, " ")).c_str());
    add_feature(layer, row, file, errors);
  }
}

/// Likewise.
void write_signs(GDALDataset& dataset, const std::vector<NodeSign>& signs, const std::string& file,
                 const GdalErrors& errors) {
  if (signs.empty()) return;
  OGRLayer& layer = create_layer(dataset, "signs", wkbNone, nullptr, sign_fields);
  for (const NodeSign& sign : signs) {
    OGRFeature row(layer.GetLayerDefn());
    row.SetField("osm_node", static_cast<GIntBig>(sign.osm_node));
    row.SetField("kind", to_string(sign.kind));
    row.SetField("direction", sign.direction);
    row.SetField("value", sign.value.c_str());
    row.SetField("size_m", sign.size_m);
    row.SetField("closed", sign.closed ? 1 : 0);
    add_feature(layer, row, file, errors);
  }
}

/// The table in which QGIS looks for styles of a GeoPackage's layers, as QGIS makes it.
void write_styles(GDALDataset& dataset, const std::string& file, const GdalErrors& errors) {
  constexpr Field fields[] = {{"f_table_catalog", OFTString},
                              {"f_table_schema", OFTString},
                              {"f_table_name", OFTString},
                              {"f_geometry_column", OFTString},
                              {"styleName", OFTString},
                              {"styleQML", OFTString},
                              {"styleSLD", OFTString},
                              {"useAsDefault", OFTInteger},
                              {"description", OFTString},
                              {"owner", OFTString},
                              {"ui", OFTString},
                              {"update_time", OFTDateTime}};
  OGRLayer& layer = create_layer(dataset, "layer_styles", wkbNone, nullptr, fields);
  for (const char* name : {"centrelines", "surface"}) {
    OGRFeature row(layer.GetLayerDefn());
    for (const char* empty : {"f_table_catalog", "f_table_schema", "styleSLD", "owner"}) row.SetField(empty, "");
    row.SetField("f_table_name", name);
    row.SetField("f_geometry_column", dataset.GetLayerByName(name)->GetGeometryColumn());
    row.SetField("styleName", "orthodrive");
    row.SetField("styleQML", qgis_road_style(name).c_str());
    row.SetField("useAsDefault", 1);
    row.SetField("description", "by highway");
    row.SetField("update_time", 2000, 1, 1, 0, 0, 0.0F, 100);  // the same bytes at any time
    add_feature(layer, row, file, errors);
  }
}
}  // namespace

void write_roads(const fs::path& path, const RoadNetwork& roads, const std::vector<RoughnessStretch>& roughness) {
  write_geopackage(path, [&](GDALDataset& dataset, const GdalErrors& errors) {
    OGRSpatialReference reference = spatial_reference(roads.crs);
    RoadsWriter writer(dataset, reference, path.string(), errors);
    for (const RoadPath& road : roads.paths) writer.add(road);
    if (!roughness.empty()) write_roughness(dataset, reference, roads, roughness, path.string(), errors);
    write_restrictions(dataset, roads.restrictions, path.string(), errors);
    write_signs(dataset, roads.signs, path.string(), errors);
    write_styles(dataset, path.string(), errors);
  });
}

namespace {
OGRLayer& need_layer(const fs::path& path, GDALDataset& dataset, const char* name) {
  OGRLayer* layer = dataset.GetLayerByName(name);
  if (!layer)
    throw InputError(path.string(),
                     fmt::format("has no layer '{}'; need a roads.gpkg as `orthodrive refine` writes it", name));
  return *layer;
}

template <std::size_t n>
void need_fields(const fs::path& path, OGRLayer& layer, const Field (&fields)[n]) {
  for (const Field& field : fields)
    if (layer.GetLayerDefn()->GetFieldIndex(field.name) < 0)
      throw InputError(path.string(),
                       fmt::format("layer '{}' has no field '{}'; need a roads.gpkg as `orthodrive refine` writes it",
                                   layer.GetName(), field.name));
}

using PathKey = std::pair<std::int64_t, int>;  // osm_id, part
PathKey key_of(const OGRFeature& row) { return {row.GetFieldAsInteger64("osm_id"), row.GetFieldAsInteger("part")}; }

Sides sides_of_number(int value) { return value >= 0 && value <= 3 ? static_cast<Sides>(value) : Sides::none; }

void read_lane_fields(const OGRFeature& row, RoadPath& path) {
  if (row.GetFieldIndex(lane_fields[0].name) < 0) return;
  path.lanes_forward = row.GetFieldAsInteger("lanes_forward");
  path.lanes_backward = row.GetFieldAsInteger("lanes_backward");
  path.turn_forward = row.GetFieldAsString("turn_forward");
  path.turn_backward = row.GetFieldAsString("turn_backward");
  path.speed_limit_kmh = row.GetFieldAsDouble("speed_limit_kmh");
  path.sidewalk = sides_of_number(row.GetFieldAsInteger("sidewalk"));
  path.shoulder = sides_of_number(row.GetFieldAsInteger("shoulder"));
  path.surface = row.GetFieldAsString("surface");
}

void read_use_fields(const OGRFeature& row, RoadPath& path) {
  for (const Field& field : use_fields)
    if (row.GetFieldIndex(field.name) < 0) return;
  path.lanes_both_ways = row.GetFieldAsInteger("lanes_both_ways");
  path.use_forward = row.GetFieldAsString("use_forward");
  path.use_backward = row.GetFieldAsString("use_backward");
  path.use = row.GetFieldAsString("use");
  path.side_lanes = row.GetFieldAsString("side_lanes");
  path.speeds_forward = row.GetFieldAsString("speeds_forward");
  path.speeds_backward = row.GetFieldAsString("speeds_backward");
  const auto place = [&](const char* name) {
    const int field = row.GetFieldIndex(name);
    return row.IsFieldSetAndNotNull(field) ? row.GetFieldAsDouble(field) : -1.0;
  };
  path.placement = {row.GetFieldAsInteger("placement_backward") != 0, place("placement_start"), place("placement_end"),
                    row.GetFieldAsInteger("placement_transition") != 0};
}

/// Of an older file, and where somebody wrote no class: what the tags say.
KnownSurface known_surface_of(const OGRFeature& row, const RoadPath& path) {
  if (row.GetFieldIndex(class_fields[0].name) < 0 || row.GetFieldIndex(class_fields[1].name) < 0)
    return surface_of_tags(path.highway, path.surface, "");
  const auto surface = roadquery::surface_class_of(row.GetFieldAsString("surface_class"));
  if (!surface) return surface_of_tags(path.highway, path.surface, "");
  return {*surface, surface_source_of(row.GetFieldAsString("surface_source"))};
}

RoadPath path_of(const OGRFeature& row) {
  RoadPath path;
  std::tie(path.osm_id, path.part) = key_of(row);
  path.highway = row.GetFieldAsString("highway");
  path.name = row.GetFieldAsString("name");
  path.layer = row.GetFieldAsInteger("layer");
  path.bridge = row.GetFieldAsInteger("bridge") != 0;
  path.tunnel = row.GetFieldAsInteger("tunnel") != 0;
  path.oneway = row.GetFieldAsInteger("oneway") != 0 ? Oneway::forward : Oneway::no;
  path.lanes = row.GetFieldAsInteger("lanes");
  path.roundabout = row.GetFieldAsInteger("roundabout") != 0;
  read_lane_fields(row, path);
  read_use_fields(row, path);
  for (const auto& [name, text] : {std::pair{"speed_context", &path.speed_context},
                                   {"traffic_calming", &path.traffic_calming},
                                   {"widths_forward", &path.widths_forward},
                                   {"widths_backward", &path.widths_backward},
                                   {"widths_both_ways", &path.widths_both_ways}})
    if (const int field = row.GetFieldIndex(name); field >= 0) *text = row.GetFieldAsString(field);
  path.known_surface = known_surface_of(row, path);
  return path;
}

RoadNode node_of(const fs::path& path, const OGRFeature& row) {
  const OGRGeometry* geometry = row.GetGeometryRef();
  if (!geometry || wkbFlatten(geometry->getGeometryType()) != wkbPoint)
    throw InputError(path.string(), fmt::format("feature {} of layer 'nodes' is no point", row.GetFID()));
  RoadNode node;
  node.p = {geometry->toPoint()->getX(), geometry->toPoint()->getY()};
  node.osm_node = row.GetFieldAsInteger64("osm_node");
  node.s_m = row.GetFieldAsDouble("s_m");
  node.offset_m = row.GetFieldAsDouble("offset_m");
  node.width_m = row.GetFieldAsDouble("width_m");
  node.sigma_offset_m = row.GetFieldAsDouble("sigma_offset_m");
  node.sigma_width_m = row.GetFieldAsDouble("sigma_width_m");
  const int z = row.GetFieldIndex("z_m");
  if (row.IsFieldSetAndNotNull(z)) node.z_m = row.GetFieldAsDouble(z);
  node.gradient = row.GetFieldAsDouble("gradient");
  node.banking = row.GetFieldAsDouble("banking");
  node.sigma_z_m = row.GetFieldAsDouble("sigma_z_m");
  node.banking_source = banking_source_of(row.GetFieldAsString("banking_source"));
  if (const int crown = row.GetFieldIndex("crown"); crown >= 0) node.crown = row.GetFieldAsDouble(crown);
  if (const int sigma = row.GetFieldIndex("sigma_banking"); sigma >= 0)
    node.sigma_banking = row.GetFieldAsDouble(sigma);
  if (const int radius = row.GetFieldIndex("kerb_radius_m"); radius >= 0)
    node.kerb_radius_m = row.GetFieldAsDouble(radius);
  return node;
}
}  // namespace

bool holds_roads(const fs::path& path) {
  const DatasetPtr dataset = open_dataset(path, GDAL_OF_VECTOR);
  return dataset->GetLayerByName("centrelines") && dataset->GetLayerByName("nodes");
}

namespace {
/// Over which ways a restriction goes; none in files of older versions.
std::vector<std::int64_t> via_ways_of(const fs::path& path, const OGRFeature& row) {
  const int field = row.GetFieldIndex(later_restriction_field.name);
  if (field < 0) return {};
  std::vector<std::int64_t> ways;
  std::istringstream text(row.GetFieldAsString(field));
  for (std::int64_t way = 0; text >> way;) ways.push_back(way);
  if (!text.eof())
    throw InputError(path.string(), fmt::format("has a restriction with via_ways='{}', need numbers of ways",
                                                printable(row.GetFieldAsString(field))));
  return ways;
}
}  // namespace

RoadNetwork read_roads(const fs::path& path) {
  const DatasetPtr dataset = open_dataset(path, GDAL_OF_VECTOR);
  OGRLayer& centrelines = need_layer(path, *dataset, "centrelines");
  OGRLayer& nodes = need_layer(path, *dataset, "nodes");
  need_fields(path, centrelines, centreline_fields);
  need_fields(path, nodes, node_fields);
  if (!centrelines.GetSpatialRef()) throw InputError(path.string(), "has no coordinate reference system");

  GdalErrors errors;
  RoadNetwork roads{.crs = crs_of(*centrelines.GetSpatialRef())};
  std::map<PathKey, std::size_t> index;
  for (const auto& row : centrelines) {
    if (!index.emplace(key_of(*row), roads.paths.size()).second)
      throw InputError(path.string(), fmt::format("has way {} part {} twice", key_of(*row).first, key_of(*row).second));
    roads.paths.push_back(path_of(*row));
  }
  for (const auto& row : nodes) {
    const auto at = index.find(key_of(*row));
    if (at == index.end())
      throw InputError(path.string(), fmt::format("has nodes of way {} part {}, which is not in 'centrelines'",
                                                  key_of(*row).first, key_of(*row).second));
    roads.paths[at->second].nodes.push_back(node_of(path, *row));
  }
  if (OGRLayer* restrictions = dataset->GetLayerByName("restrictions")) {
    need_fields(path, *restrictions, restriction_fields);
    for (const auto& row : *restrictions)
      roads.restrictions.push_back({row->GetFieldAsInteger64("from_way"), row->GetFieldAsInteger64("via_node"),
                                    row->GetFieldAsInteger64("to_way"), row->GetFieldAsInteger("only") != 0,
                                    via_ways_of(path, *row)});
  }
  if (OGRLayer* signs = dataset->GetLayerByName("signs")) {
    need_fields(path, *signs, old_sign_fields);  // files of older versions have no more
    const bool is_old = signs->GetLayerDefn()->GetFieldIndex("value") < 0;
    for (const auto& row : *signs) {
      const auto kind = node_sign_kind_of(row->GetFieldAsString("kind"));
      if (!kind) throw InputError(path.string(), fmt::format("has a sign '{}'", row->GetFieldAsString("kind")));
      NodeSign& sign = roads.signs.emplace_back(
          NodeSign{row->GetFieldAsInteger64("osm_node"), *kind, row->GetFieldAsInteger("direction")});
      if (is_old) continue;
      sign.value = row->GetFieldAsString("value"), sign.size_m = row->GetFieldAsDouble("size_m");
      sign.closed = row->GetFieldAsInteger("closed") != 0;
    }
  }
  if (errors.any())
    throw InputError(path.string(), fmt::format("cannot be read to its end ({}); make it again", errors.text()));
  for (RoadPath& road : roads.paths) {
    std::stable_sort(road.nodes.begin(), road.nodes.end(),
                     [](const RoadNode& a, const RoadNode& b) { return a.s_m < b.s_m; });
    if (road.nodes.size() < 2)
      throw InputError(path.string(),
                       fmt::format("way {} part {} has {} nodes, need two", road.osm_id, road.part, road.nodes.size()));
  }
  return roads;
}

std::vector<RoughnessStretch> read_roughness(const fs::path& path) {
  const DatasetPtr dataset = open_dataset(path, GDAL_OF_VECTOR);
  std::vector<RoughnessStretch> roughness;
  OGRLayer* layer = dataset->GetLayerByName("roughness");
  if (!layer) return roughness;
  need_fields(path, *layer, roughness_fields);
  for (const auto& row : *layer) {
    RoughnessStretch& stretch = roughness.emplace_back();
    std::tie(stretch.osm_id, stretch.part) = key_of(*row);
    stretch.s_begin_m = row->GetFieldAsDouble("s_begin_m"), stretch.s_end_m = row->GetFieldAsDouble("s_end_m");
    stretch.gd_n0_m3 = row->GetFieldAsDouble("gd_n0_m3"), stretch.waviness = row->GetFieldAsDouble("waviness");
    stretch.sigma_ln_gd = row->GetFieldAsDouble("sigma_ln_gd");
    stretch.iso_8608_class = iso_8608_class(stretch.gd_n0_m3);
  }
  std::stable_sort(roughness.begin(), roughness.end(), [](const RoughnessStretch& a, const RoughnessStretch& b) {
    return std::tie(a.osm_id, a.part, a.s_begin_m) < std::tie(b.osm_id, b.part, b.s_begin_m);
  });
  return roughness;
}

}  // namespace orthodrive::io
