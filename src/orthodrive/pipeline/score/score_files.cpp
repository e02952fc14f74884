// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/score/score_files.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
bool is_osm_file(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.ends_with(".pbf") || name.ends_with(".osm") || name.find(".osm.") != std::string::npos;
}

MultiPolygon read_polygons(const fs::path& path, const Crs& crs) {
  MultiPolygon all;
  for (const io::Feature& feature : io::read_features(path, crs))
    all.insert(all.end(), feature.polygons.begin(), feature.polygons.end());
  if (all.empty()) throw InputError(path.string(), "has no polygons");
  return all;
}

std::string tag(const io::Feature& feature, const char* key) {
  const auto at = feature.tags.find(key);
  return at == feature.tags.end() ? std::string() : at->second;
}
}  // namespace

ScoreRegion read_region(const RegionFiles& files, const Crs& crs) {
  ScoreRegion region;
  if (!files.area.empty()) region.area = read_polygons(files.area, crs);
  if (!files.ignore.empty()) region.ignore = read_polygons(files.ignore, crs);
  return region;
}

fs::path inside_folder(const fs::path& path, const char* name) { return fs::is_directory(path) ? path / name : path; }

bool is_vector_file(const fs::path& path) {
  constexpr std::array extensions{".geojson", ".json", ".gpkg", ".shp"};
  return is_osm_file(path) || std::find(extensions.begin(), extensions.end(), path.extension()) != extensions.end();
}

namespace {
/// Index of the first that matches; `added` goes to the end when there is none.
template <typename T, typename Matches>
std::size_t index_of(std::vector<T>& all, const Matches& matches, T added) {
  const auto at = std::find_if(all.begin(), all.end(), matches);
  const auto index = static_cast<std::size_t>(at - all.begin());
  if (at == all.end()) all.push_back(std::move(added));
  return index;
}

/// Label of the class. One that the prediction does not know cannot be right, but must count.
std::uint8_t label_of(const std::string& name, std::vector<ClassInfo>& classes, const fs::path& path) {
  if (name == "unknown") return label_nodata;
  const auto label = index_of(
      classes, [&](const ClassInfo& c) { return c.name == name; }, ClassInfo{.name = name});
  if (label >= label_nodata) throw InputError(path.string(), "has more than 255 classes");
  return static_cast<std::uint8_t>(label);
}

/// What TruthPieces::index holds for the piece.
std::uint16_t number_of(const std::string& piece, std::vector<std::string>& names, const fs::path& path) {
  if (piece.empty()) return 0;
  const auto index = index_of(
      names, [&](const std::string& n) { return n == piece; }, piece);
  if (index >= 65535) throw InputError(path.string(), "has more than 65535 pieces");
  return static_cast<std::uint16_t>(index + 1);
}

LabelTruth paint_truth(const fs::path& path, const std::vector<io::Feature>& features, const LabelMap& prediction) {
  const GridFrame& frame = prediction.frame;
  LabelTruth truth{.map = {prediction.crs, frame, Raster<std::uint8_t>(frame.width, frame.height, 1, label_nodata),
                           prediction.classes}};
  TruthPieces& pieces = truth.pieces;
  const bool in_pieces =
      std::any_of(features.begin(), features.end(), [](const io::Feature& f) { return !tag(f, "piece").empty(); });
  if (in_pieces) pieces.index = Raster<std::uint16_t>(frame.width, frame.height);
  for (const io::Feature& feature : features) {
    const std::string name = tag(feature, "class");
    if (name.empty() || feature.polygons.empty()) continue;
    const std::uint8_t label = label_of(name, truth.map.classes.classes, path);
    const std::uint16_t piece = number_of(tag(feature, "piece"), pieces.names, path);
    for (const Polygon& polygon : feature.polygons) {
      fill_polygon(truth.map.labels, frame, polygon, label);
      if (in_pieces) fill_polygon(pieces.index, frame, polygon, piece);
    }
  }
  return truth;
}
}  // namespace

std::variant<LabelTruth, MultiPolygon> read_label_truth(const fs::path& path, const LabelMap& prediction) {
  if (!is_vector_file(path)) return LabelTruth{.map = io::read_labels(path, prediction.classes)};
  const std::vector<io::Feature> features = io::read_features(path, prediction.crs);
  if (std::none_of(features.begin(), features.end(), [](const io::Feature& f) { return f.tags.contains("class"); }))
    return read_polygons(path, prediction.crs);
  return paint_truth(path, features, prediction);
}

MergeTable read_merge_table(const fs::path& path) {
  if (!fs::exists(path))
    throw InputError(path.string(), "no such file; need a TOML table of old = \"new\" class names");
  toml::table file;
  try {
    file = toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    throw InputError(path.string(), fmt::format("line {}: {}; need lines of old = \"new\" class names",
                                                error.source().begin.line, error.description()));
  }
  MergeTable table;
  for (const auto& [from, to] : file) {
    const auto name = to.value_exact<std::string>();
    if (!name || name->empty())
      throw InputError(path.string(), fmt::format("line {}: '{}' needs the name of a class in quotes",
                                                  to.source().begin.line, from.str()));
    table.emplace(from.str(), *name);
  }
  if (table.empty()) throw InputError(path.string(), "merges nothing; need lines of old = \"new\" class names");
  return table;
}

namespace {
void add_features(RoadTruth& truth, const std::vector<io::Feature>& features) {
  for (const io::Feature& feature : features) {
    if (!feature.polygons.empty()) truth.surfaces.push_back({tag(feature, "id"), feature.polygons});
    for (const Polyline& line : feature.lines)
      if (line.size() >= 2) truth.lines.push_back({tag(feature, "of"), line, {}});
  }
}
}  // namespace

RoadTruth read_road_truth(const fs::path& path, const Crs& crs) {
  RoadTruth truth;
  if (!fs::is_directory(path)) {
    if (path.extension() == ".gpkg" && io::holds_roads(path)) return road_truth(io::read_roads(path), crs);
    add_features(truth, io::read_features(path, crs));
  } else {
    // The roads have exact widths; the surfaces are what others can look at. Centre lines alone must do without either.
    const bool has_roads = fs::exists(path / "roads.gpkg"), has_surface = fs::exists(path / "surface.geojson");
    if (has_roads) truth = road_truth(io::read_roads(path / "roads.gpkg"), crs);
    if (has_surface) truth.surfaces.clear(), add_features(truth, io::read_features(path / "surface.geojson", crs));
    if (!has_roads && fs::exists(path / "centrelines.geojson"))
      add_features(truth, io::read_features(path / "centrelines.geojson", crs));
  }
  if (truth.surfaces.empty() && truth.lines.empty())
    throw InputError(
        path.string(),
        "has neither carriageway polygons nor centre lines; need GeoJSON, GeoPackage or a folder with surface.geojson");
  return truth;
}

namespace {
Box2 bounds_of_truth(const RoadTruth& truth) {
  Ring points;
  for (const TruthSurface& surface : truth.surfaces)
    for (const Polygon& polygon : surface.polygons)
      points.insert(points.end(), polygon.outer.begin(), polygon.outer.end());
  for (const TruthLine& line : truth.lines) points.insert(points.end(), line.line.begin(), line.line.end());
  return bounds_of(points);
}
}  // namespace

RoadNetwork read_scored_roads(const fs::path& path, const fs::path& truth) {
  if (!is_osm_file(path)) return io::read_roads(path);
  const Crs lonlat{"EPSG:4326"};
  const Box2 somewhere = bounds_of_truth(read_road_truth(truth, lonlat));
  const Crs crs = utm_crs(0.5 * (somewhere.min_x + somewhere.max_x), 0.5 * (somewhere.min_y + somewhere.max_y));
  return io::read_osm_roads(path, {crs, polygon_of(bounds_of_truth(read_road_truth(truth, crs)))});
}

}  // namespace orthodrive
