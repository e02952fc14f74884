// SPDX-License-Identifier: Apache-2.0
// Everything of an OSM file that has a tag: buildings, water, parking ... as polygons and lines.

#include <algorithm>
#include <osmium/area/assembler.hpp>
#include <osmium/area/multipolygon_manager.hpp>
#include <osmium/handler/node_locations_for_ways.hpp>
#include <osmium/index/map/flex_mem.hpp>
#include <osmium/osm/area.hpp>
#include <osmium/visitor.hpp>

#include "orthodrive/io/osm/object_kind.hpp"
#include "orthodrive/io/support/osm_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {
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
    features_.push_back({.points = {at}, .tags = tags_of(node.tags())});
  }
  void way(const osmium::Way& way) {
    if (way.tags().empty() || way.nodes().empty() || (way.is_closed() && !is_linear(way.tags()))) return;
    Polyline line = line_of(way.nodes(), transform_);
    if (line.size() >= 2) features_.push_back({.lines = {std::move(line)}, .tags = tags_of(way.tags())});
  }

 private:
  std::vector<Feature>& features_;
  const CoordinateTransform& transform_;
};

Feature feature_of(const osmium::Area& area, const CoordinateTransform& transform) {
  Feature feature{.tags = tags_of(area.tags()),
                  .osm_id = (area.from_way() ? "way/" : "relation/") + std::to_string(area.orig_id())};
  for (const osmium::OuterRing& outer : area.outer_rings()) {
    Polygon polygon{ring_of(outer, transform), {}};
    for (const osmium::InnerRing& inner : area.inner_rings(outer)) polygon.holes.push_back(ring_of(inner, transform));
    feature.polygons.push_back(std::move(polygon));
  }
  return feature;
}
}  // namespace

std::vector<Feature> read_osm_features(const std::filesystem::path& path, const Crs& target_crs) {
  using Index = osmium::index::map::FlexMem<osmium::unsigned_object_id_type, osmium::Location>;
  return with_osm_errors(path, [&] {
    osmium::area::MultipolygonManager<osmium::area::Assembler> polygons{osmium::area::Assembler::config_type{}};
    read_osm_buffers(path, osmium::osm_entity_bits::relation,
                     [&](const osmium::memory::Buffer& buffer) { osmium::apply(buffer, polygons); });
    polygons.prepare_for_lookup();

    const CoordinateTransform transform(Crs{"EPSG:4326"}, target_crs);
    std::vector<Feature> features;
    Index index;
    osmium::handler::NodeLocationsForWays locations(index);
    locations.ignore_errors();  // extracts cut ways: what is left of them is used
    LineHandler lines(features, transform);
    auto& second_pass = polygons.handler([&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Area& area : buffer.select<osmium::Area>())
        if (!area.tags().empty() && !(area.from_way() && is_linear(area.tags())))
          features.push_back(feature_of(area, transform));
    });
    read_osm_buffers(path, osmium::osm_entity_bits::nwr, [&](osmium::memory::Buffer& buffer) {
      for (osmium::OSMEntity& entity : buffer.select<osmium::OSMEntity>())
        osmium::apply_item(entity, locations, lines, second_pass);
    });
    second_pass.flush();
    return features;
  });
}

}  // namespace orthodrive::io
