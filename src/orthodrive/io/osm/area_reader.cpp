// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/area_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <osmium/area/assembler.hpp>
#include <osmium/osm/area.hpp>
#include <osmium/osm/relation.hpp>
#include <osmium/osm/way.hpp>
#include <unordered_map>

#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/support/osm_support.hpp"
#include "orthodrive/io/support/read_file.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t most_geojson_bytes = 64U << 20;  // a country's border has a few megabytes

void largest_first(MultiPolygon& polygons) {
  std::stable_sort(polygons.begin(), polygons.end(),
                   [](const Polygon& a, const Polygon& b) { return area_m2(a) > area_m2(b); });
}

std::vector<Ring> rings_of(const json& coordinates) {
  std::vector<Ring> rings;
  for (const json& points : coordinates) {
    Ring ring;
    for (const json& point : points) ring.push_back({point.at(0).get<double>(), point.at(1).get<double>()});
    rings.push_back(std::move(ring));
  }
  return rings;
}

/// Of a geometry, a feature or a collection; other geometries than polygons are passed over.
void collect_polygons(const json& object, MultiPolygon& polygons) {
  const std::string type = object.at("type").get<std::string>();
  if (type == "FeatureCollection") {
    for (const json& feature : object.at("features")) collect_polygons(feature, polygons);
  } else if (type == "GeometryCollection") {
    for (const json& geometry : object.at("geometries")) collect_polygons(geometry, polygons);
  } else if (type == "Feature") {
    if (!object.at("geometry").is_null()) collect_polygons(object.at("geometry"), polygons);
  } else if (type == "Polygon") {
    polygons.push_back(polygon_of_rings(rings_of(object.at("coordinates"))));
  } else if (type == "MultiPolygon") {
    for (const json& part : object.at("coordinates")) polygons.push_back(polygon_of_rings(rings_of(part)));
  }
}

/// RFC 7946 knows WGS84 only; writers of the format before it name a CRS.
void check_crs_member(const json& object, const fs::path& path) {
  if (!object.contains("crs") || object["crs"].is_null()) return;
  const std::string name = object["crs"].value("properties", json::object()).value("name", std::string("unknown"));
  if (name.find("CRS84") == std::string::npos && name.find("4326") == std::string::npos)
    throw InputError(path.string(), fmt::format("is in the CRS {}; save it in WGS84 (EPSG:4326), as GeoJSON has to be",
                                                printable(name)));
}

/// What a relation is made of, and how much of it the file has.
struct RelationParts {
  osmium::memory::Buffer relation{1024, osmium::memory::Buffer::auto_grow::yes};
  osmium::memory::Buffer ways{1 << 16, osmium::memory::Buffer::auto_grow::yes};
  std::unordered_map<osmium::object_id_type, osmium::Location> nodes;
  std::size_t wanted_ways = 0, found_ways = 0;
};

std::vector<osmium::object_id_type> ways_of(const osmium::Relation& relation) {
  std::vector<osmium::object_id_type> ids;
  for (const osmium::RelationMember& member : relation.members())
    if (member.type() == osmium::item_type::way) ids.push_back(member.ref());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

RelationParts read_parts(const fs::path& path, std::int64_t id) {
  RelationParts parts;
  std::int64_t relations = 0;
  read_osm_buffers(path, osmium::osm_entity_bits::relation, [&](const osmium::memory::Buffer& buffer) {
    for (const osmium::Relation& relation : buffer.select<osmium::Relation>()) {
      ++relations;
      if (relation.id() != id || parts.relation.committed() > 0) continue;
      parts.relation.add_item(relation);
      parts.relation.commit();
    }
  });
  if (parts.relation.committed() == 0)
    throw InputError(path.string(), fmt::format("has no relation {} among its {}; take the extract of a larger region, "
                                                "or look the number up at openstreetmap.org",
                                                id, relations));
  const std::vector<osmium::object_id_type> ids = ways_of(*parts.relation.begin<osmium::Relation>());
  parts.wanted_ways = ids.size();
  read_osm_buffers(path, osmium::osm_entity_bits::way, [&](const osmium::memory::Buffer& buffer) {
    for (const osmium::Way& way : buffer.select<osmium::Way>()) {
      if (!std::binary_search(ids.begin(), ids.end(), way.id())) continue;
      parts.ways.add_item(way);
      parts.ways.commit();
      ++parts.found_ways;
      for (const osmium::NodeRef& node : way.nodes()) parts.nodes.emplace(node.ref(), node.location());
    }
  });
  read_osm_buffers(path, osmium::osm_entity_bits::node, [&](const osmium::memory::Buffer& buffer) {
    for (const osmium::Node& node : buffer.select<osmium::Node>())
      if (const auto wanted = parts.nodes.find(node.id()); wanted != parts.nodes.end())
        wanted->second = node.location();
  });
  return parts;
}

/// Puts the places of nodes into the ways and says what is not in the file.
void check_complete(const fs::path& path, std::int64_t id, RelationParts& parts) {
  std::size_t lost_nodes = 0;
  for (osmium::Way& way : parts.ways.select<osmium::Way>())
    for (osmium::NodeRef& node : way.nodes()) {
      node.set_location(parts.nodes.at(node.ref()));
      if (!node.location().valid()) ++lost_nodes;
    }
  const std::string remedy = "; take the extract of a larger region, or give the place as a polygon";
  if (parts.wanted_ways == 0)
    throw InputError(path.string(), fmt::format("relation {} has no way and so no area{}", id, remedy));
  if (parts.found_ways < parts.wanted_ways)
    throw InputError(path.string(), fmt::format("relation {} is incomplete: {} of its {} ways are not in the file{}",
                                                id, parts.wanted_ways - parts.found_ways, parts.wanted_ways, remedy));
  if (lost_nodes > 0)
    throw InputError(path.string(), fmt::format("relation {} is incomplete: {} of its nodes are not in the file{}", id,
                                                lost_nodes, remedy));
}

template <typename NodeRefs>
Ring lonlat_ring(const NodeRefs& nodes) {
  Ring ring;
  for (const osmium::NodeRef& node : nodes) ring.push_back({node.location().lon(), node.location().lat()});
  if (ring.size() > 1) ring.pop_back();  // the repeat of the first
  return ring;
}

MultiPolygon assemble(const RelationParts& parts) {
  const osmium::Relation& relation = *parts.relation.begin<osmium::Relation>();
  std::unordered_map<osmium::object_id_type, const osmium::Way*> by_id;
  for (const osmium::Way& way : parts.ways.select<osmium::Way>()) by_id.emplace(way.id(), &way);
  std::vector<const osmium::Way*> members;
  for (const osmium::RelationMember& member : relation.members())
    if (member.type() == osmium::item_type::way) members.push_back(by_id.at(member.ref()));
  osmium::memory::Buffer areas{1 << 16, osmium::memory::Buffer::auto_grow::yes};
  const osmium::area::Assembler::config_type config;
  osmium::area::Assembler assembler{config};
  MultiPolygon polygons;
  if (!assembler(relation, members, areas)) return polygons;
  for (const osmium::Area& area : areas.select<osmium::Area>())
    for (const osmium::OuterRing& outer : area.outer_rings()) {
      Polygon polygon{lonlat_ring(outer), {}};
      for (const osmium::InnerRing& inner : area.inner_rings(outer)) polygon.holes.push_back(lonlat_ring(inner));
      polygons.push_back(std::move(polygon));
    }
  return polygons;
}

}  // namespace

Polygon polygon_of_rings(std::vector<Ring> rings) {
  if (rings.empty()) throw OptionError("a polygon without a ring");
  for (std::size_t i = 0; i < rings.size(); ++i) {
    Ring& ring = rings[i];
    for (const Vec2 p : ring)
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) throw OptionError("has a corner that is no number");
    if (ring.size() < 2 || ring.front() != ring.back())
      throw OptionError(fmt::format("ring {} of a polygon is not closed; repeat its first position at its end", i + 1));
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    ring.pop_back();
  }
  Polygon polygon;
  polygon.outer = std::move(rings.front());
  if (signed_area_m2(polygon.outer) < 0.0) std::reverse(polygon.outer.begin(), polygon.outer.end());
  for (std::size_t i = 1; i < rings.size(); ++i) {
    if (signed_area_m2(rings[i]) > 0.0) std::reverse(rings[i].begin(), rings[i].end());
    polygon.holes.push_back(std::move(rings[i]));
  }
  return polygon;
}

MultiPolygon read_areas(const fs::path& path) {
  if (!fs::is_regular_file(path)) throw InputError(path.string(), "no such file; need GeoJSON with a polygon");
  if (fs::file_size(path) > most_geojson_bytes)
    throw InputError(path.string(), "is larger than 64 MB; give the outline of the area alone");
  MultiPolygon polygons;
  try {
    const json object = json::parse(read_file(path));
    check_crs_member(object, path);
    collect_polygons(object, polygons);
  } catch (const json::exception& error) {
    throw InputError(path.string(), fmt::format("is no GeoJSON with a polygon ({}); save the area as GeoJSON",
                                                printable(error.what())));
  } catch (const OptionError& error) {
    throw InputError(path.string(), error.what());
  }
  if (polygons.empty()) throw InputError(path.string(), "holds no polygon; draw the area as a closed polygon");
  largest_first(polygons);
  return polygons;
}

Polygon read_area(const fs::path& path) {
  MultiPolygon polygons = read_areas(path);
  if (polygons.size() > 1)
    throw InputError(
        path.string(),
        fmt::format("holds {} polygons, and a site is one; keep one, or make a site of each", polygons.size()));
  return std::move(polygons.front());
}

MultiPolygon read_relation(const fs::path& path, std::int64_t relation_id) {
  return with_osm_errors(path, [&] {
    RelationParts parts = read_parts(path, relation_id);
    check_complete(path, relation_id, parts);
    MultiPolygon polygons = assemble(parts);
    if (polygons.empty())
      throw InputError(path.string(), fmt::format("the ways of relation {} close no ring; it may be a route: take the "
                                                  "boundary of a place, or give the place as a polygon",
                                                  relation_id));
    largest_first(polygons);
    return polygons;
  });
}

}  // namespace orthodrive::io
