// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/tuning/tune_sites.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/pipeline/files/refine_files.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"
#include "orthodrive/pipeline/score/score_files.hpp"
#include "orthodrive/roads/cut_corners.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {

/// An entry of the file.
struct SiteEntry {
  std::string name, fold;
  fs::path labels, road_probability, osm, truth;
  RegionFiles region;
  bool pieces = false;
};

void read_file_of(TomlSection& section, const char* key, fs::path& path) {
  section.read(key, path);
  if (!path.empty() && !fs::exists(path)) section.fail_here(fmt::format("'{}': no such file: {}", key, path.string()));
}

SiteEntry read_entry(TomlSection& section) {
  SiteEntry entry;
  for (const char* key : {"name", "labels", "osm", "truth"}) section.require(key);
  section.read("name", entry.name);
  entry.fold = entry.name;
  section.read("fold", entry.fold);
  section.read("pieces", entry.pieces);
  read_file_of(section, "labels", entry.labels);
  read_file_of(section, "road_probability", entry.road_probability);
  read_file_of(section, "osm", entry.osm);
  read_file_of(section, "truth", entry.truth);
  read_file_of(section, "area", entry.region.area);
  read_file_of(section, "ignore", entry.region.ignore);
  if (entry.name.empty() || entry.fold.empty()) section.fail_here("'name' and 'fold' must not be empty");
  if (entry.pieces && entry.region.area.empty()) section.fail_here("'pieces' needs 'area', whose polygons they are");
  return entry;
}

std::vector<SiteEntry> read_site_entries(const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw InputError(file.string(), "no such file; need a TOML file of [[site]], `orthodrive tune --help` shows one");
  const toml::table table = parse_toml(io::read_file(file), file);
  TomlSection root(table, file);
  std::vector<SiteEntry> entries;
  std::set<std::string> names;
  root.for_each_table("site", [&](TomlSection& section) {
    entries.push_back(read_entry(section));
    if (!names.insert(entries.back().name).second)
      section.fail_here(fmt::format("a site '{}' is there already", entries.back().name));
  });
  root.finish();
  if (entries.empty()) root.fail_here("has no [[site]]");
  return entries;
}

}  // namespace

namespace {

Box2 bounds_of_area(const MultiPolygon& area) {
  Ring points;
  for (const Polygon& polygon : area) points.insert(points.end(), polygon.outer.begin(), polygon.outer.end());
  return bounds_of(points);
}

bool comes_into(const Box2& box, const Polyline& line) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    if (bounds_of({line[i], line[i + 1]}).overlaps(box)) return true;
  return false;
}

/// What lies far from the area can change nothing there, but costs time.
void crop(TuneSite& site) {
  if (!site.region.area) return;
  const Box2 area = bounds_of_area(*site.region.area);
  constexpr double roads_m =
      150.0;  // roads act on each other through junctions and as neighbours: a few tens of metres
  std::erase_if(site.osm.paths,
                [&](const RoadPath& path) { return !comes_into(area.grown(roads_m), centerline(path)); });
  std::erase_if(site.truth.surfaces, [&](const TruthSurface& s) { return !bounds_of_area(s.polygons).overlaps(area); });
  std::erase_if(site.truth.lines, [&](const TruthLine& line) { return !comes_into(area, line.line); });
  std::erase_if(site.region.ignore, [&](const Polygon& polygon) { return !bounds_of(polygon.outer).overlaps(area); });
}

struct AreaPiece {
  std::string name;
  MultiPolygon area;
};
std::vector<AreaPiece> read_pieces(const fs::path& path, const Crs& crs) {
  std::vector<AreaPiece> pieces;
  for (io::Feature& feature : io::read_features(path, crs)) {
    if (feature.polygons.empty()) continue;
    const auto name = feature.tags.find("piece");
    pieces.push_back(
        {name == feature.tags.end() ? std::to_string(pieces.size() + 1) : name->second, std::move(feature.polygons)});
  }
  return pieces;
}

bool lies_in(const Polygon& outline, const MultiPolygon& area) {
  return std::ranges::all_of(area, [&](const Polygon& polygon) {
    return std::ranges::all_of(polygon.outer, [&](Vec2 p) { return contains(outline, p); });
  });
}

/// Whether a loss can be told, and roads can change it.
bool is_usable(const TuneSite& site) {
  return !site.osm.paths.empty() && !std::isnan(road_loss(site.osm, site).loss_m);
}

void add_sites(TuneSites& all, const SiteEntry& entry, const fs::path& file, Monitor* monitor) {
  const LabelMap labels = io::read_labels(entry.labels);
  const SiteFrame frame = labelled_site(entry.labels, labels);
  TuneSite whole{.name = entry.name, .fold = entry.fold, .evidence = all.evidence.size()};
  whole.osm = io::read_osm_roads(entry.osm, frame);
  cut_at_corners(whole.osm);
  whole.truth = read_road_truth(entry.truth, frame.crs);
  whole.region = read_region(entry.region, frame.crs);

  const std::size_t before = all.sites.size();
  const auto add = [&](TuneSite site) {
    if (site.region.area) crop(site);
    if (is_usable(site)) all.sites.push_back(std::move(site));
  };
  std::size_t asked = 1;
  if (entry.pieces) {
    const std::vector<AreaPiece> pieces = read_pieces(entry.region.area, frame.crs);
    asked = pieces.size();
    for (const AreaPiece& piece : pieces) {
      if (!lies_in(frame.area, piece.area)) continue;
      TuneSite site = whole;
      site.name += "/" + piece.name;
      site.region.area = piece.area;
      add(std::move(site));
    }
  } else {
    add(std::move(whole));
  }
  const std::size_t added = all.sites.size() - before;
  if (added == 0)
    throw InputError(
        file.string(),
        fmt::format("site '{}': no place of its labels has both roads and a true centre line", entry.name));
  if (monitor && entry.pieces)
    monitor->info(fmt::format("{}: {} of {} pieces have labels, roads and truth", entry.name, added, asked));
  all.evidence.push_back(read_evidence(labels, entry.road_probability));
}

}  // namespace

TuneSites read_tune_sites(const fs::path& file, Monitor* monitor) {
  TuneSites all;
  for (const SiteEntry& entry : read_site_entries(file)) add_sites(all, entry, file, monitor);
  return all;
}

namespace {

double mean_of(const std::vector<double>& values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

RoadLoss road_loss(const RoadNetwork& roads, const TuneSite& site) {
  // So far refinement may move a road. A road that is lost there costs no less than one that is as far off, so that no
  // weights gain by losing one.
  constexpr double farthest_m = RefineRoadsOptions{}.search_radius_m;
  const RoadScores scores = evaluate_roads(roads, site.truth, {.region = site.region});
  std::vector<double> offsets, width_errors;
  offsets.reserve(scores.places.size());
  for (const RoadPlace& place : scores.places) {
    offsets.push_back(std::isnan(place.offset_m) ? farthest_m : std::min(std::abs(place.offset_m), farthest_m));
    if (!std::isnan(place.width_error_m)) width_errors.push_back(std::abs(place.width_error_m));
  }
  RoadLoss loss{.offset_m = mean_of(offsets),
                .width_m = mean_of(width_errors),
                .surface_iou = scores.surface_iou,
                .unmatched_share = 1.0 - scores.matched_share};
  loss.loss_m = loss.offset_m;
  if (!std::isnan(loss.width_m)) loss.loss_m += 0.5 * loss.width_m;
  if (!std::isnan(loss.surface_iou)) loss.loss_m += 1.0 - loss.surface_iou;
  return loss;
}

}  // namespace orthodrive
