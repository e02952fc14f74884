#include "orthodrive/pipeline/score_files.hpp"

#include <algorithm>
#include <array>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"

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

std::variant<LabelMap, MultiPolygon> read_label_truth(const fs::path& path, const LabelMap& prediction) {
  if (!is_vector_file(path)) return io::read_labels(path, prediction.classes);
  const std::vector<io::Feature> features = io::read_features(path, prediction.crs);
  if (std::none_of(features.begin(), features.end(), [](const io::Feature& f) { return f.tags.contains("class"); }))
    return read_polygons(path, prediction.crs);
  LabelMap truth{prediction.crs, prediction.frame,
                 Raster<std::uint8_t>(prediction.frame.width, prediction.frame.height, 1, label_nodata),
                 prediction.classes};
  std::vector<ClassInfo>& classes = truth.classes.classes;
  for (const io::Feature& feature : features) {
    const std::string name = tag(feature, "class");
    if (name.empty() || feature.polygons.empty()) continue;
    auto at = std::find_if(classes.begin(), classes.end(), [&](const ClassInfo& c) { return c.name == name; });
    if (at == classes.end()) {  // a class that the prediction does not know cannot be right, but must count
      if (classes.size() == label_nodata) throw InputError(path.string(), "has more than 255 classes");
      at = classes.insert(at, {.name = name});
    }
    for (const Polygon& polygon : feature.polygons)
      fill_polygon(truth.labels, truth.frame, polygon, static_cast<std::uint8_t>(at - classes.begin()));
  }
  return truth;
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
  const Box2 box = bounds_of_truth(read_road_truth(truth, crs));
  const Polygon area{{{box.min_x, box.min_y}, {box.max_x, box.min_y}, {box.max_x, box.max_y}, {box.min_x, box.max_y}},
                     {}};
  return io::read_osm_roads(path, {crs, area});
}

}  // namespace orthodrive
