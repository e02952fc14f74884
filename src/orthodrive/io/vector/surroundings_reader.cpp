// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/surroundings_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "orthodrive/io/osm/object_kind.hpp"
#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/model/roads/road_material.hpp"

namespace orthodrive::io {
namespace {

using Tags = std::map<std::string, std::string>;

constexpr double max_barrier_height_m = 20.0, max_object_m = 400.0;

std::string tag_of(const Tags& tags, const char* key) {
  const auto found = tags.find(key);
  return found == tags.end() ? "" : found->second;
}

template <std::size_t N>
bool is_one_of(const std::string& value, const std::array<std::string_view, N>& names) {
  return std::ranges::find(names, value) != names.end();
}

bool is_true(const std::string& value) { return !value.empty() && value != "no" && value != "0"; }

bool has_no_tags(const Tags& tags) {
  return std::ranges::all_of(tags, [](const auto& entry) { return entry.second.empty(); });
}

std::optional<BarrierKind> barrier_kind(const std::string& barrier) {
  constexpr std::array<std::string_view, 3> walls = {"wall", "retaining_wall", "city_wall"};
  constexpr std::array<std::string_view, 3> fences = {"fence", "railing", "handrail"};
  if (barrier == "hedge") return BarrierKind::hedge;
  if (barrier == "guard_rail") return BarrierKind::guard_rail;
  if (is_one_of(barrier, walls)) return BarrierKind::wall;
  if (is_one_of(barrier, fences)) return BarrierKind::fence;
  return std::nullopt;
}

bool is_water(const Tags& tags) {
  constexpr std::array<std::string_view, 2> basins = {"reservoir", "basin"};
  return tag_of(tags, "natural") == "water" || tag_of(tags, "waterway") == "riverbank" ||
         tag_of(tags, "t") == "water" || is_one_of(tag_of(tags, "landuse"), basins) || has_no_tags(tags);
}

/// Ground to drive into, not what is built on it.
bool is_gravel(const Tags& tags) {
  constexpr std::array<std::string_view, 2> natural = {"shingle", "sand"};
  constexpr std::array<std::string_view, 4> surfaces = {"gravel", "fine_gravel", "pebblestone", "sand"};
  if (is_one_of(tag_of(tags, "natural"), natural)) return true;
  return is_one_of(tag_of(tags, "surface"), surfaces) && tag_of(tags, "building").empty();
}

/// Not garages and what lies below the ground.
bool is_parking(const Tags& tags) {
  constexpr std::array<std::string_view, 4> built = {"underground", "multi-storey", "rooftop", "garage_boxes"};
  if (is_true(tag_of(tags, "building"))) return false;
  return (tag_of(tags, "amenity") == "parking" && !is_one_of(tag_of(tags, "parking"), built)) ||
         tag_of(tags, "t") == "parking";
}

bool is_track(const Tags& tags) {
  constexpr std::array<std::string_view, 5> kinds = {"rail", "light_rail", "tram", "narrow_gauge", "preserved"};
  return is_one_of(tag_of(tags, "railway"), kinds) || tag_of(tags, "t") == "rail";
}

/// Metres, of ways for people on foot or bicycles that tell no width; 0 for other ways. The middle of what EFA (FGSV
/// 2002) and ERA (FGSV 2010) ask and what paths in parks have.
double path_width_m(const Tags& tags) {
  constexpr std::array<std::pair<std::string_view, double>, 6> usual = {
      {{"footway", 2.0}, {"cycleway", 2.5}, {"pedestrian", 4.0}, {"path", 1.2}, {"bridleway", 1.5}, {"steps", 1.5}}};
  constexpr double least_m = 0.5, most_m = 15.0;
  const std::string highway = tag_of(tags, "highway"), layer = tag_of(tags, "layer");
  if (is_true(tag_of(tags, "indoor")) || layer.starts_with('-') || tag_of(tags, "footway") == "crossing" ||
      tag_of(tags, "cycleway") == "crossing" || tag_of(tags, "path") == "crossing")
    return 0.0;
  const auto found = std::ranges::find(usual, std::string_view(highway), &std::pair<std::string_view, double>::first);
  if (found == usual.end()) return 0.0;
  const double told_m = parse_width_m(tag_of(tags, "width"));
  return told_m > 0.0 ? std::clamp(told_m, least_m, most_m) : found->second;
}

class Collector {
 public:
  Collector(const SiteFrame& site, Findings* findings) : area_(bounds_of(site.area.outer)), findings_(findings) {}

  void add(Feature& feature) {
    const Tags& tags = feature.tags;
    if (is_true(tag_of(tags, "tunnel")) || is_true(tag_of(tags, "bridge")) || is_true(tag_of(tags, "br")) ||
        is_true(tag_of(tags, "covered")))
      return;
    if (const auto kind = barrier_kind(tag_of(tags, "barrier"))) return add_barrier(*kind, feature);
    if (is_track(tags)) return add_lines(feature.lines);
    if (tag_of(tags, "highway") == "street_lamp") return add_lamps(feature.points);
    if (const double width_m = path_width_m(tags); width_m > 0.0) return add_paths(feature, width_m);
    const std::string power = tag_of(tags, "power");
    if (power == "line" || power == "minor_line") return add_power_lines(feature.lines, power == "minor_line");
    if (const auto kind = object_kind(tags)) return add_objects(*kind, feature);
    if (is_gravel(tags)) return add_areas(feature, result.gravel, "gravel");
    if (is_parking(tags)) return add_areas(feature, result.parking, "a car park");
    if (is_water(tags)) add_areas(feature, result.water, "water");
  }

  MapSurroundings result;

 private:
  [[nodiscard]] bool is_near(const Polyline& line) const {
    if (line.empty()) return false;
    const Box2 box = bounds_of(line);
    return box.max_x >= area_.min_x && box.min_x <= area_.max_x && box.max_y >= area_.min_y && box.min_y <= area_.max_y;
  }
  void add_barrier(BarrierKind kind, const Feature& feature) {
    const auto add_line = [&](const Polyline& line) {
      if (line.size() < 2 || !is_near(line)) return;
      result.barriers.push_back({kind, line, height_m(feature.tags, line.front(), {max_barrier_height_m, "barrier"})});
    };
    for (const Polyline& line : feature.lines) add_line(line);
    for (const Polygon& polygon : feature.polygons) {
      Polyline closed = polygon.outer;
      if (!closed.empty()) closed.push_back(closed.front());
      add_line(closed);
    }
  }
  void add_areas(Feature& feature, MultiPolygon& areas, const char* what) {
    const MissingArea& missing = feature.missing;
    if (findings_ && !missing.why.empty() && missing.box.overlaps(area_))
      findings_->push_back({Severity::info, "surroundings.no_area",
                            fmt::format("{} ({}): {}; it is left out", feature.osm_id, what, missing.why),
                            std::clamp(0.5 * (missing.box.min_x + missing.box.max_x), area_.min_x, area_.max_x),
                            std::clamp(0.5 * (missing.box.min_y + missing.box.max_y), area_.min_y, area_.max_y)});
    for (Polygon& polygon : feature.polygons)
      if (polygon.outer.size() >= 3 && is_near(polygon.outer)) areas.push_back(std::move(polygon));
  }
  void add_lines(std::vector<Polyline>& lines) {
    for (Polyline& line : lines)
      if (line.size() >= 2 && is_near(line)) result.tracks.push_back(std::move(line));
  }
  void add_paths(Feature& feature, double width_m) {
    const Tags& tags = feature.tags;
    const KnownSurface known =
        surface_of_tags(tag_of(tags, "highway"), tag_of(tags, "surface"), tag_of(tags, "tracktype"));
    for (Polyline& line : feature.lines)
      if (line.size() >= 2 && is_near(line)) result.paths.push_back({std::move(line), width_m, known.surface});
  }
  void add_lamps(const std::vector<Vec2>& points) {
    for (const Vec2 p : points)
      if (area_.contains(p)) result.lamps.push_back(p);
  }
  void add_power_lines(std::vector<Polyline>& lines, bool is_minor) {
    for (Polyline& line : lines)
      if (line.size() >= 2 && is_near(line)) result.power_lines.push_back({std::move(line), is_minor});
  }
  /// Areas stand at their middle, as round as they are large.
  void add_objects(ObjectKind kind, const Feature& feature) {
    const auto add_at = [&](Vec2 p, double radius_m) {
      if (area_.contains(p))
        result.objects.push_back({kind, p, height_m(feature.tags, p, {max_object_m, "object"}), radius_m});
    };
    for (const Vec2 p : feature.points) add_at(p, 0.5 * parse_width_m(tag_of(feature.tags, "diameter")));
    for (const Polygon& polygon : feature.polygons) {
      if (polygon.outer.size() < 3) continue;
      const Box2 box = bounds_of(polygon.outer);
      add_at({0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)},
             std::sqrt(area_m2(polygon) / std::numbers::pi));
    }
  }
  struct HeightOf {
    double most_m;
    std::string_view what;
  };
  /// 0 for what is not known; what is odd is told.
  double height_m(const Tags& tags, Vec2 at, const HeightOf& of) {
    const std::string text = tag_of(tags, "height");
    if (text.empty()) return 0.0;
    const double value = parse_width_m(text);
    if (value > 0.0 && value <= of.most_m) return value;
    if (findings_)
      findings_->push_back(
          {Severity::info, "surroundings.odd_height",
           fmt::format("height '{}' of a {} is no number up to {:.0f} and does not count", text, of.what, of.most_m),
           at.x, at.y});
    return 0.0;
  }

  Box2 area_;
  Findings* findings_;
};

}  // namespace

MapSurroundings read_surroundings(const std::vector<std::filesystem::path>& files, const SiteFrame& site,
                                  Findings* findings) {
  Collector collector(site, findings);
  for (Feature& feature : read_features(files, site.crs)) collector.add(feature);
  return std::move(collector.result);
}

}  // namespace orthodrive::io
