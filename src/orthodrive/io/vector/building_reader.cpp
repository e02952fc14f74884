// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/building_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <string_view>

#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/io/support/map_color.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {

constexpr double max_height_m = 500.0, max_levels = 150.0;

const std::string* tag(const OsmTags& tags, std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (const auto found = tags.find(key); found != tags.end() && !found->second.empty()) return &found->second;
  return nullptr;
}

constexpr double level_m = 3.0;  // S3DB: where only levels are known
constexpr double max_angle_deg = 80.0;

/// Reads the tags of one feature; what is odd does not count and is told.
class BuildingTags {
 public:
  BuildingTags(const OsmTags& tags, Vec2 at, Findings* findings) : tags_(tags), at_(at), findings_(findings) {}

  struct Limit {
    double most;
    const char* what;
  };
  /// 0 for tags that are absent or odd.
  [[nodiscard]] double number(std::initializer_list<const char*> keys, const Limit& limit) const {
    const std::string* text = tag(tags_, keys);
    if (!text) return 0.0;
    const double value = parse_width_m(*text);
    if (value > 0.0 && value <= limit.most) return value;
    tell(fmt::format("a building's {} '{}' is no number up to {:.0f} and does not count", limit.what, *text,
                     limit.most));
    return 0.0;
  }
  /// Likewise for what may well be 0.
  [[nodiscard]] double number_or_zero(const char* key, const Limit& limit) const {
    const std::string* text = tag(tags_, {key});
    return text && *text == "0" ? 0.0 : number({key}, limit);
  }
  [[nodiscard]] std::string text(const char* key) const {
    const std::string* found = tag(tags_, {key});
    return found ? *found : std::string();
  }
  void tell(std::string message) const {
    if (findings_) findings_->push_back({Severity::info, "buildings.odd_height", std::move(message), at_.x, at_.y});
  }

 private:
  const OsmTags& tags_;
  Vec2 at_;
  Findings* findings_;
};

/// Counter-clockwise from east, of a compass bearing in degrees or a name of up to three letters.
std::optional<double> direction_rad(const std::string& text) {
  constexpr std::array<std::string_view, 16> names = {"N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE",
                                                      "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW"};
  if (text.empty()) return std::nullopt;
  double bearing_deg = 0.0;
  if (const auto name = std::ranges::find(names, text); name != names.end()) {
    bearing_deg = 22.5 * static_cast<double>(name - names.begin());
  } else {
    const char* end = text.data() + text.size();
    const auto [rest, failed] = std::from_chars(text.data(), end, bearing_deg);
    if (failed != std::errc() || rest != end || !(std::abs(bearing_deg) <= 360.0)) return std::nullopt;
  }
  return (90.0 - bearing_deg) * std::numbers::pi / 180.0;
}

void read_heights(const BuildingTags& tags, Building& building) {
  building.height_m = tags.number({"height", "h"}, {max_height_m, "height"});
  building.levels = tags.number({"building:levels", "lv"}, {max_levels, "levels"});
  building.min_height_m = tags.number_or_zero("min_height", {max_height_m, "min_height"});
  if (building.min_height_m == 0.0)
    building.min_height_m = level_m * tags.number_or_zero("building:min_level", {max_levels, "min_level"});
  const double top_m = building.height_m > 0.0 ? building.height_m : level_m * building.levels;
  if (top_m > 0.0 && building.min_height_m >= top_m) {
    tags.tell(fmt::format("a building that begins at {:.1f} m and ends at {:.1f} m begins at the ground",
                          building.min_height_m, top_m));
    building.min_height_m = 0.0;
  }
}

void read_roof(const BuildingTags& tags, Building& building) {
  building.roof_shape = tags.text("roof:shape");
  building.roof_height_m = tags.number_or_zero("roof:height", {max_height_m, "roof:height"});
  building.roof_levels = tags.number_or_zero("roof:levels", {max_levels, "roof:levels"});
  building.roof_angle_rad = tags.number_or_zero("roof:angle", {max_angle_deg, "roof:angle"}) * std::numbers::pi / 180.0;
  building.roof_direction_rad = direction_rad(tags.text("roof:direction"));
  building.ridge_across = tags.text("roof:orientation") == "across";
  building.roof_material = tags.text("roof:material");
  const double most_m = building.height_m - building.min_height_m;
  if (building.height_m > 0.0 && building.roof_height_m > most_m) {
    tags.tell(
        fmt::format("a roof of {:.1f} m on a building of {:.1f} m does not count", building.roof_height_m, most_m));
    building.roof_height_m = 0.0;
  }
}

void read_colors(const BuildingTags& tags, Building& building) {
  const auto color = [](const std::string& name, const std::string& material) {
    const auto named = map_color(name);
    return named ? named : material_color(material);
  };
  building.material = tags.text("building:material");
  building.wall_color = color(tags.text("building:colour"), building.material);
  building.roof_color = color(tags.text("roof:colour"), building.roof_material);
}

/// Of a building whose outline is a line, or none at all.
void report_missing(const Feature& feature, const Box2& area, Findings* findings) {
  MissingArea missing = feature.missing;
  if (missing.why.empty() && feature.polygons.empty() && !feature.lines.empty() && !feature.osm_id.empty())
    missing = {"its outline is not closed", bounds_of(feature.lines.front())};
  if (!findings || missing.why.empty() || !missing.box.overlaps(area)) return;
  const double x = std::clamp(0.5 * (missing.box.min_x + missing.box.max_x), area.min_x, area.max_x),
               y = std::clamp(0.5 * (missing.box.min_y + missing.box.max_y), area.min_y, area.max_y);
  findings->push_back({Severity::info, "buildings.no_area",
                       fmt::format("{}: {}; the building is left out", feature.osm_id, missing.why), x, y});
}

}  // namespace

std::vector<Building> read_buildings(const std::vector<std::filesystem::path>& files, const SiteFrame& site,
                                     Findings* findings) {
  const Box2 area = bounds_of(site.area.outer);
  std::vector<Building> buildings;
  for (Feature& feature : read_features(files, site.crs)) {
    const std::string* part = tag(feature.tags, {"building:part"});
    const std::string* use = tag(feature.tags, {"building", "t"});
    const bool is_part = (!use || *use == "no") && part && *part != "no";
    if (is_part) use = part;
    if (!use || *use == "no") continue;
    report_missing(feature, area, findings);
    for (Polygon& polygon : feature.polygons) {
      if (polygon.outer.size() < 3) continue;
      const Box2 box = bounds_of(polygon.outer);
      if (box.max_x < area.min_x || box.min_x > area.max_x || box.max_y < area.min_y || box.min_y > area.max_y)
        continue;
      const BuildingTags tags(feature.tags, polygon.outer.front(), findings);
      Building building{.footprint = std::move(polygon), .use = *use, .is_part = is_part, .osm_id = feature.osm_id};
      building.has_walls = *use != "roof" && *use != "carport" && tags.text("wall") != "no";
      read_heights(tags, building);
      read_roof(tags, building);
      read_colors(tags, building);
      buildings.push_back(std::move(building));
    }
  }
  return buildings;
}

}  // namespace orthodrive::io
