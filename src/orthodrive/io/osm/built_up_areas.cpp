// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/built_up_areas.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <osmium/osm/node.hpp>
#include <osmium/osm/relation.hpp>
#include <osmium/osm/way.hpp>
#include <set>
#include <string_view>

#include "orthodrive/geo/segment.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/io/support/osm_support.hpp"

namespace orthodrive::io {
namespace {
using Files = std::vector<std::filesystem::path>;
constexpr double near_m = 25.0;  // half of a wide street with its verges

bool is_built_up(const osmium::TagList& tags) {
  const std::string_view use = tags.get_value_by_key("landuse", "");
  return use == "residential" || use == "commercial" || use == "retail" || use == "industrial";
}

/// What the files have of such areas: rings by the ids of their ways, the ways, the places of their nodes.
class Reading {
 public:
  explicit Reading(const Files& files) {
    for_each(files, osmium::osm_entity_bits::relation, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Relation& relation : buffer.select<osmium::Relation>()) add(relation);
    });
    for_each(files, osmium::osm_entity_bits::way, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Way& way : buffer.select<osmium::Way>()) add(way);
    });
    for_each(files, osmium::osm_entity_bits::node, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Node& node : buffer.select<osmium::Node>())
        if (const auto it = place_of_.find(node.id()); it != place_of_.end() && node.location().valid())
          it->second = lonlat_of(node.location());
    });
  }

  /// Segments of each area in degrees; areas that lack a way or a node are not there.
  [[nodiscard]] std::vector<std::vector<std::pair<Vec2, Vec2>>> areas() const {
    std::vector<std::vector<std::pair<Vec2, Vec2>>> areas;
    for (const auto& ways : ways_of_area_) {
      std::vector<std::pair<Vec2, Vec2>> segments;
      if (std::ranges::all_of(ways, [&](std::int64_t way) { return append(way, segments); }) && !segments.empty())
        areas.push_back(std::move(segments));
    }
    return areas;
  }

 private:
  template <typename Use>
  static void for_each(const Files& files, osmium::osm_entity_bits::type kind, const Use& use) {
    for (const std::filesystem::path& path : files) with_osm_errors(path, [&] { read_osm_buffers(path, kind, use); });
  }
  void add(const osmium::Relation& relation) {
    if (!relation.tags().has_tag("type", "multipolygon") || !is_built_up(relation.tags())) return;
    std::vector<std::int64_t> ways;
    for (const osmium::RelationMember& member : relation.members())
      if (member.type() == osmium::item_type::way) ways.push_back(member.ref());
    wanted_.insert(ways.begin(), ways.end());
    if (seen_relations_.insert(relation.id()).second) ways_of_area_.push_back(std::move(ways));
  }
  void add(const osmium::Way& way) {
    const bool is_area = way.nodes().size() > 3 && way.is_closed() && is_built_up(way.tags());
    if (!is_area && !wanted_.contains(way.id())) return;
    const auto [it, is_new] = ways_.try_emplace(way.id());
    if (!is_new) return;
    for (const osmium::NodeRef& node : way.nodes()) {
      it->second.push_back(node.ref());
      Vec2& place = place_of_.try_emplace(node.ref(), lonlat_of(node.location())).first->second;
      if (std::isnan(place.x)) place = lonlat_of(node.location());  // where the way itself tells
    }
    if (is_area) ways_of_area_.push_back({way.id()});
  }
  bool append(std::int64_t id, std::vector<std::pair<Vec2, Vec2>>& segments) const {
    const auto way = ways_.find(id);
    if (way == ways_.end()) return false;
    Vec2 before;
    for (std::size_t i = 0; i < way->second.size(); ++i) {
      const Vec2 place = place_of_.at(way->second[i]);
      if (std::isnan(place.x)) return false;
      if (i > 0) segments.emplace_back(before, place);
      before = place;
    }
    return true;
  }

  std::vector<std::vector<std::int64_t>> ways_of_area_;
  std::set<std::int64_t> wanted_, seen_relations_;
  std::map<std::int64_t, std::vector<std::int64_t>> ways_;  ///< their nodes
  std::map<std::int64_t, Vec2> place_of_;
};

Box2 bounds_of_segments(const std::vector<std::pair<Vec2, Vec2>>& segments) {
  Ring ends;
  for (const auto& [a, b] : segments) ends.push_back(a), ends.push_back(b);
  return bounds_of(ends);
}
}  // namespace

BuiltUpAreas::BuiltUpAreas(const Files& files, const SiteFrame& site) {
  const Box2 area_lonlat = lonlat_bounds(site.area.outer, site.crs);
  const CoordinateTransform site_from_lonlat(Crs{"EPSG:4326"}, site.crs);
  std::vector<Box2> boxes;
  for (Area segments : Reading(files).areas()) {
    if (!bounds_of_segments(segments).overlaps(area_lonlat)) continue;  // far ones may have no place in the CRS
    for (auto& [a, b] : segments)
      a = site_from_lonlat.target_from_source(a), b = site_from_lonlat.target_from_source(b);
    boxes.push_back(bounds_of_segments(segments));
    areas_.push_back(std::move(segments));
  }
  index_ = SpatialIndex(boxes);
}

bool BuiltUpAreas::holds(Vec2 place) const {
  const auto holds_place = [&](const Area& area) {
    bool is_inside = false;
    for (const auto& [a, b] : area) {
      if (distance_to_segment(a, b, place) <= near_m) return true;
      if ((a.y > place.y) != (b.y > place.y) && place.x < a.x + (place.y - a.y) / (b.y - a.y) * (b.x - a.x))
        is_inside = !is_inside;
    }
    return is_inside;
  };
  return std::ranges::any_of(index_.near(place, near_m), [&](std::uint32_t i) { return holds_place(areas_[i]); });
}

}  // namespace orthodrive::io
