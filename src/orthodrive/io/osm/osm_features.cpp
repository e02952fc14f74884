// SPDX-License-Identifier: Apache-2.0
// Everything of an OSM file that has a tag: buildings, water, parking ... as polygons and lines.

#include <algorithm>
#include <osmium/area/assembler.hpp>
#include <osmium/area/multipolygon_manager.hpp>
#include <osmium/handler.hpp>
#include <osmium/index/map/flex_mem.hpp>
#include <osmium/osm/area.hpp>
#include <osmium/visitor.hpp>

#include "orthodrive/io/osm/area_problems.hpp"
#include "orthodrive/io/osm/object_kind.hpp"
#include "orthodrive/io/support/osm_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {
constexpr const char* not_in_file = "a part of its outline is not in the file, take a larger extract";

/// Closed ways with these keys are lines that come back to their start, unless area=yes says otherwise.
bool is_linear(const osmium::TagList& tags) {
  if (tags.has_tag("area", "yes")) return false;
  return tags.has_key("highway") || tags.has_key("barrier") || tags.has_key("railway") ||
         tags.has_tag("power", "line") || tags.has_tag("power", "minor_line");
}

template <typename NodeRefs>
Polyline line_of(const NodeRefs& nodes, const CoordinateTransform& target_from_lonlat) {
  Polyline line;
  for (const osmium::NodeRef& node : nodes)
    if (node.location().valid())
      line.push_back(target_from_lonlat.target_from_source({node.location().lon(), node.location().lat()}));
  return line;
}

template <typename NodeRefs>
Ring ring_of(const NodeRefs& nodes, const CoordinateTransform& target_from_lonlat) {
  Ring ring = line_of(nodes, target_from_lonlat);
  if (ring.size() > 1) ring.pop_back();  // the repeat of the first
  return ring;
}

/// Lines, and the points that anything here reads: trees, street lamps, objects.
class LineHandler : public osmium::handler::Handler {
 public:
  LineHandler(std::vector<Feature>& features, const CoordinateTransform& transform)
      : features_(features), transform_(transform) {}
  void node(const osmium::Node& node) {
    if (node.tags().empty() || !node.location().valid()) return;
    const bool is_read = node.tags().has_tag("natural", "tree") || node.tags().has_tag("highway", "street_lamp") ||
                         object_kind(tags_of(node.tags()));
    if (!is_read) return;
    const Vec2 at = transform_.target_from_source({node.location().lon(), node.location().lat()});
    features_.push_back({.points = {at},
                         .tags = tags_of(node.tags()),
                         .osm_id = "node/" + std::to_string(node.id()),
                         .osm_version = node.version()});
  }
  void way(const osmium::Way& way) {
    if (way.tags().empty() || way.nodes().empty()) return;
    if (way.is_closed() && !is_linear(way.tags())) return add_cut_area(way);
    Polyline line = line_of(way.nodes(), transform_);
    if (line.size() >= 2)
      features_.push_back({.lines = {std::move(line)},
                           .tags = tags_of(way.tags()),
                           .osm_id = "way/" + std::to_string(way.id()),
                           .osm_version = way.version()});
  }

 private:
  /// libosmium passes over areas of which nodes are missing.
  void add_cut_area(const osmium::Way& way) {
    Ring lonlat;
    for (const osmium::NodeRef& node : way.nodes())
      if (node.location().valid()) lonlat.push_back(lonlat_of(node.location()));
    if (lonlat.empty() || lonlat.size() == way.nodes().size()) return;
    features_.push_back({.tags = tags_of(way.tags()),
                         .osm_id = "way/" + std::to_string(way.id()),
                         .osm_version = way.version(),
                         .missing = {not_in_file, AreaProblems::box_of(lonlat, transform_)}});
  }
  std::vector<Feature>& features_;
  const CoordinateTransform& transform_;
};

using Multipolygons = osmium::area::MultipolygonManager<osmium::area::Assembler>;

/// Multipolygons of which ways are missing.
void add_incomplete(Multipolygons& polygons, const CoordinateTransform& transform, std::vector<Feature>& features) {
  polygons.for_each_incomplete_relation([&](const osmium::relations::RelationHandle& handle) {
    Ring lonlat;
    for (const osmium::RelationMember& member : handle->members()) {
      const osmium::Way* way =
          member.type() == osmium::item_type::way ? polygons.get_member_way(member.ref()) : nullptr;
      if (!way) continue;
      for (const osmium::NodeRef& node : way->nodes())
        if (node.location().valid()) lonlat.push_back(lonlat_of(node.location()));
    }
    if (lonlat.empty()) return;
    features.push_back({.tags = tags_of(handle->tags()),
                        .osm_id = "relation/" + std::to_string(handle->id()),
                        .osm_version = handle->version(),
                        .missing = {not_in_file, AreaProblems::box_of(lonlat, transform)}});
  });
}

/// Puts places into the nodes of ways. Nodes come first; places that stand in the way itself (`out geom`) stay where
/// the file has no node. What extracts cut stays without a place: what is left of such ways is used.
class PlaceHandler : public osmium::handler::Handler {
 public:
  void node(const osmium::Node& node) {
    if (node.id() < 0)
      negative_.set(static_cast<osmium::unsigned_object_id_type>(-node.id()), node.location());
    else
      positive_.set(node.positive_id(), node.location());
    is_sorted_ = false;
  }
  void way(osmium::Way& way) {
    if (!is_sorted_) positive_.sort(), negative_.sort(), is_sorted_ = true;
    for (osmium::NodeRef& ref : way.nodes()) {
      const osmium::Location known =
          ref.ref() < 0 ? negative_.get_noexcept(static_cast<osmium::unsigned_object_id_type>(-ref.ref()))
                        : positive_.get_noexcept(ref.positive_ref());
      if (known.valid()) ref.set_location(known);
    }
  }

 private:
  using Index = osmium::index::map::FlexMem<osmium::unsigned_object_id_type, osmium::Location>;
  Index positive_, negative_;
  bool is_sorted_ = true;
};

Feature feature_of(const osmium::Area& area, const CoordinateTransform& transform) {
  Feature feature{.tags = tags_of(area.tags()),
                  .osm_id = (area.from_way() ? "way/" : "relation/") + std::to_string(area.orig_id()),
                  .osm_version = area.version()};
  for (const osmium::OuterRing& outer : area.outer_rings()) {
    Polygon polygon{ring_of(outer, transform), {}};
    for (const osmium::InnerRing& inner : area.inner_rings(outer)) polygon.holes.push_back(ring_of(inner, transform));
    feature.polygons.push_back(std::move(polygon));
  }
  return feature;
}
}  // namespace

std::vector<Feature> read_osm_features(const std::filesystem::path& path, const Crs& target_crs) {
  return with_osm_errors(path, [&] {
    AreaProblems problems;
    osmium::area::Assembler::config_type config;
    config.problem_reporter = &problems;
    Multipolygons polygons{config};
    read_osm_buffers(path, osmium::osm_entity_bits::relation,
                     [&](const osmium::memory::Buffer& buffer) { osmium::apply(buffer, polygons); });
    polygons.prepare_for_lookup();

    const CoordinateTransform transform(Crs{"EPSG:4326"}, target_crs);
    std::vector<Feature> features;
    PlaceHandler places;
    LineHandler lines(features, transform);
    auto& second_pass = polygons.handler([&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Area& area : buffer.select<osmium::Area>())
        if (!area.tags().empty() && !(area.from_way() && is_linear(area.tags()))) {
          features.push_back(feature_of(area, transform));
          if (features.back().polygons.empty()) features.back().missing = problems.missing(area, transform);
        }
    });
    read_osm_sorted(path, [&](osmium::memory::Buffer& buffer) {
      for (osmium::OSMEntity& entity : buffer.select<osmium::OSMEntity>())
        osmium::apply_item(entity, places, lines, second_pass);
    });
    second_pass.flush();
    add_incomplete(polygons, transform, features);
    return features;
  });
}

}  // namespace orthodrive::io
