#include "orthodrive/io/building_reader.hpp"

#include <fmt/format.h>

#include "orthodrive/io/map_color.hpp"
#include "orthodrive/io/osm_tags.hpp"
#include "orthodrive/io/vector_io.hpp"

namespace orthodrive::io {
namespace {

constexpr double max_height_m = 500.0, max_levels = 150.0;

const std::string* tag(const OsmTags& tags, std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (const auto found = tags.find(key); found != tags.end() && !found->second.empty()) return &found->second;
  return nullptr;
}

/// 0 for tags that are absent or odd; those are told.
double number(const OsmTags& tags, std::initializer_list<const char*> keys, double most, const char* what, Vec2 at,
              Findings* findings) {
  const std::string* text = tag(tags, keys);
  if (!text) return 0.0;
  const double value = parse_width_m(*text);
  if (value > 0.0 && value <= most) return value;
  if (findings)
    findings->push_back(
        {Severity::info, "buildings.odd_height",
         fmt::format("a building's {} '{}' is no number up to {:.0f} and does not count", what, *text, most), at.x,
         at.y});
  return 0.0;
}

}  // namespace

std::vector<Building> read_buildings(const std::vector<std::filesystem::path>& files, const SiteFrame& site,
                                     Findings* findings) {
  const Box2 area = bounds_of(site.area.outer);
  std::vector<Building> buildings;
  for (const std::filesystem::path& file : files) {
    for (Feature& feature : read_features(file, site.crs)) {
      const std::string* use = tag(feature.tags, {"building", "t"});
      if (!use || *use == "no" || *use == "roof" || *use == "carport") continue;
      for (Polygon& polygon : feature.polygons) {
        if (polygon.outer.size() < 3) continue;
        const Box2 box = bounds_of(polygon.outer);
        if (box.max_x < area.min_x || box.min_x > area.max_x || box.max_y < area.min_y || box.min_y > area.max_y)
          continue;
        const Vec2 at = polygon.outer.front();
        Building building{.footprint = std::move(polygon), .use = *use, .osm_id = feature.osm_id};
        building.height_m = number(feature.tags, {"height", "h"}, max_height_m, "height", at, findings);
        building.levels = number(feature.tags, {"building:levels", "lv"}, max_levels, "levels", at, findings);
        if (const std::string* shape = tag(feature.tags, {"roof:shape"})) building.roof_shape = *shape;
        if (const std::string* color = tag(feature.tags, {"building:colour"})) building.wall_color = map_color(*color);
        if (const std::string* material = tag(feature.tags, {"building:material"}); material && !building.wall_color)
          building.wall_color = material_color(*material);
        if (const std::string* color = tag(feature.tags, {"roof:colour"})) building.roof_color = map_color(*color);
        buildings.push_back(std::move(building));
      }
    }
  }
  return buildings;
}

}  // namespace orthodrive::io
