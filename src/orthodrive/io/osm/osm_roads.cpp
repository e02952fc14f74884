// SPDX-License-Identifier: Apache-2.0
// Roads of an OSM file. Two passes: first the drivable ways, then the places of their nodes, so that an extract of a
// country needs memory for its roads only.

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <osmium/osm/node.hpp>
#include <osmium/osm/relation.hpp>
#include <osmium/osm/way.hpp>
#include <set>
#include <string_view>

#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/io/osm/tag_rules.hpp"
#include "orthodrive/io/osm/turning_places.hpp"
#include "orthodrive/io/support/clip_line.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/io/support/osm_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {
struct DrivableWay {
  std::int64_t id = 0;
  WayAttributes attributes;
  std::vector<std::int64_t> nodes;
};

std::vector<DrivableWay> read_ways(const std::filesystem::path& path) {
  std::vector<DrivableWay> ways;
  read_osm_buffers(path, osmium::osm_entity_bits::way, [&](const osmium::memory::Buffer& buffer) {
    for (const osmium::Way& way : buffer.select<osmium::Way>()) {
      const char* highway = way.tags().get_value_by_key("highway");
      if (!highway || !is_drivable(highway) || way.tags().has_tag("area", "yes")) continue;
      DrivableWay& road = ways.emplace_back(DrivableWay{way.id(), way_attributes(tags_of(way.tags())), {}});
      for (const osmium::NodeRef& node : way.nodes()) road.nodes.push_back(node.ref());
      if (road.attributes.reversed) std::reverse(road.nodes.begin(), road.nodes.end());
    }
  });
  std::stable_sort(ways.begin(), ways.end(), [](const DrivableWay& a, const DrivableWay& b) { return a.id < b.id; });
  return ways;
}

/// Turns that relations forbid, or the only ones they allow. Those that count for lorries or buses alone, exempt cars
/// or go over a way instead of a node are passed over.
std::vector<TurnRestriction> read_restrictions(const std::filesystem::path& path) {
  std::vector<TurnRestriction> restrictions;
  read_osm_buffers(path, osmium::osm_entity_bits::relation, [&](const osmium::memory::Buffer& buffer) {
    for (const osmium::Relation& relation : buffer.select<osmium::Relation>()) {
      const osmium::TagList& tags = relation.tags();
      if (!tags.has_tag("type", "restriction")) continue;
      const char* kind = tags.get_value_by_key("restriction:motorcar");
      if (!kind) kind = tags.get_value_by_key("restriction", "");
      const bool only = std::string_view(kind).starts_with("only_"), no = std::string_view(kind).starts_with("no_");
      const std::string_view except = tags.get_value_by_key("except", "");
      if ((!only && !no) || except.find("motorcar") != except.npos || except.find("motor_vehicle") != except.npos)
        continue;
      std::vector<std::int64_t> from, via, to;
      for (const osmium::RelationMember& member : relation.members()) {
        const std::string_view role = member.role();
        if (member.type() == osmium::item_type::way && role == "from") from.push_back(member.ref());
        if (member.type() == osmium::item_type::node && role == "via") via.push_back(member.ref());
        if (member.type() == osmium::item_type::way && role == "to") to.push_back(member.ref());
      }
      if (via.size() != 1) continue;
      for (const std::int64_t a : from)
        for (const std::int64_t b : to) restrictions.push_back({a, via.front(), b, only});
    }
  });
  return restrictions;
}

/// Where the nodes of the ways lie, in the site CRS; NaN for nodes that the file lacks.
class NodePlaces {
 public:
  explicit NodePlaces(const std::vector<DrivableWay>& ways) {
    for (const DrivableWay& way : ways) ids_.insert(ids_.end(), way.nodes.begin(), way.nodes.end());
    std::sort(ids_.begin(), ids_.end());
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    lonlat_.assign(ids_.size(), {nan, nan});
  }
  void read(const std::filesystem::path& path) {
    read_osm_buffers(path, osmium::osm_entity_bits::node, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Node& node : buffer.select<osmium::Node>()) {
        const auto it = std::lower_bound(ids_.begin(), ids_.end(), node.id());
        if (it == ids_.end() || *it != node.id() || !node.location().valid()) continue;
        if (!node.tags().empty()) read_tags(node.id(), tags_of(node.tags()));
        lonlat_[static_cast<std::size_t>(it - ids_.begin())] = {node.location().lon(), node.location().lat()};
      }
    });
  }
  [[nodiscard]] Vec2 lonlat(std::int64_t id) const {
    return lonlat_[static_cast<std::size_t>(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin())];
  }
  /// Of the nodes of the ways, sorted; their directions are the paths'.
  [[nodiscard]] std::vector<NodeSign> signs(const std::vector<DrivableWay>& ways) const {
    std::set<std::int64_t> turned;
    for (const DrivableWay& way : ways)
      if (way.attributes.reversed) turned.insert(way.nodes.begin(), way.nodes.end());
    std::vector<NodeSign> result = signs_;
    for (NodeSign& sign : result)
      if (turned.contains(sign.osm_node)) sign.direction = -sign.direction;
    std::ranges::stable_sort(result, {}, [](const NodeSign& sign) { return std::pair(sign.osm_node, sign.kind); });
    return result;
  }
  [[nodiscard]] const std::vector<TurningPlace>& turning_places() const { return turning_places_; }
  /// Tags of the nodes that are not read.
  [[nodiscard]] const std::vector<std::pair<std::int64_t, UnreadTag>>& unread() const { return unread_; }
  [[nodiscard]] Box2 bounds() const {
    Ring known;
    for (const Vec2 p : lonlat_)
      if (!std::isnan(p.x)) known.push_back(p);
    return bounds_of(known);
  }

 private:
  void read_tags(std::int64_t id, const OsmTags& tags) {
    std::ranges::move(node_signs(id, tags), std::back_inserter(signs_));
    if (const auto place = turning_place(id, tags)) turning_places_.push_back(*place);
    for (UnreadTag& tag : unread_tags(tags, TaggedObject::node)) unread_.emplace_back(id, std::move(tag));
  }

  std::vector<std::int64_t> ids_;
  std::vector<Vec2> lonlat_;
  std::vector<NodeSign> signs_;
  std::vector<TurningPlace> turning_places_;
  std::vector<std::pair<std::int64_t, UnreadTag>> unread_;
};

/// How often tags are met that are not read, and where first.
class UnreadTags {
 public:
  void add(const std::string& tag, std::string_view reason, Vec2 where) {
    Entry& entry = entries_.try_emplace(tag, Entry{std::string(reason), where, 0}).first->second;
    ++entry.count;
  }
  void report(Findings& findings) const {
    for (const auto& [tag, entry] : entries_)
      findings.push_back(
          {Severity::info, "osm.tag_not_read",
           fmt::format("{} ({}): {}", tag, entry.count == 1 ? "once" : fmt::format("{} times, first here", entry.count),
                       entry.reason),
           entry.where.x, entry.where.y});
  }

 private:
  struct Entry {
    std::string reason;
    Vec2 where;
    int count = 0;
  };
  std::map<std::string, Entry> entries_;
};

/// Those of nodes that are on the roads, each once.
void add_unread_of_nodes(const NodePlaces& places, const RoadNetwork& roads, UnreadTags& unread) {
  std::map<std::int64_t, Vec2> place_of;
  for (const RoadPath& path : roads.paths)
    for (const RoadNode& node : path.nodes)
      if (node.osm_node != 0) place_of.emplace(node.osm_node, node.p);
  for (const auto& [id, tag] : places.unread())
    if (const auto at = place_of.find(id); at != place_of.end()) unread.add(tag.tag, tag.reason, at->second);
}

/// Nodes in a row that have a place; a node that the file lacks (extracts cut ways) splits the way.
struct NodeRun {
  Polyline line;
  std::vector<std::int64_t> nodes;
};

/// `report(code, what, where)` hears of nodes that are missing or doubled.
template <typename Report>
std::vector<NodeRun> located_runs(const DrivableWay& way, const NodePlaces& places, const Box2& area_lonlat,
                                  const CoordinateTransform& site_from_lonlat, const Report& report) {
  Ring lonlat;
  for (const std::int64_t id : way.nodes)
    if (const Vec2 p = places.lonlat(id); !std::isnan(p.x)) lonlat.push_back(p);
  if (lonlat.empty() || !bounds_of(lonlat).overlaps(area_lonlat))
    return {};  // far ones may not even have a place in the CRS
  std::vector<NodeRun> runs(1);
  std::size_t doubled = 0;
  Vec2 doubled_at;
  for (const std::int64_t id : way.nodes) {
    const Vec2 p = places.lonlat(id);
    if (std::isnan(p.x)) {
      if (!runs.back().line.empty())
        report("osm.missing_node", fmt::format("node {} is not in the file, the way is cut there", id),
               runs.back().line.back());
      if (!runs.back().line.empty()) runs.emplace_back();
      continue;
    }
    NodeRun& run = runs.back();
    const Vec2 q = site_from_lonlat.target_from_source(p);
    if (!run.line.empty() && run.line.back() == q) {  // doubled nodes make segments without a direction
      ++doubled, doubled_at = q;
      continue;
    }
    run.line.push_back(q);
    run.nodes.push_back(id);
  }
  if (doubled > 0)
    report("osm.doubled_nodes",
           fmt::format("{} of its nodes lie where the one before lies, they are left out", doubled), doubled_at);
  for (const NodeRun& run : runs)
    if (run.line.size() == 1)
      report("osm.no_length", "a part of it has one place only, it is left out", run.line.front());
  return runs;
}

RoadPath make_path(const DrivableWay& way, int part, const NodeRun& run, const std::vector<ClippedPoint>& piece) {
  RoadPath path = way.attributes.path;
  path.osm_id = way.id;
  path.part = part;
  for (const ClippedPoint& point : piece) {
    const double s_m = path.nodes.empty() ? 0.0 : path.nodes.back().s_m + distance(path.nodes.back().p, point.p);
    path.nodes.push_back({.p = point.p,
                          .osm_node = point.vertex ? run.nodes[*point.vertex] : 0,
                          .s_m = s_m,
                          .width_m = way.attributes.width_m});
  }
  return path;
}
}  // namespace

RoadNetwork read_osm_roads(const std::filesystem::path& path, const SiteFrame& site, Findings* findings) {
  constexpr double min_piece_m = 0.1;  // what is left where a way only touches the border
  return with_osm_errors(path, [&] {
    const std::vector<DrivableWay> ways = read_ways(path);
    NodePlaces places(ways);
    places.read(path);
    const CoordinateTransform site_from_lonlat(Crs{"EPSG:4326"}, site.crs);
    const Box2 area_lonlat = lonlat_bounds(site.area.outer, site.crs);
    RoadNetwork roads{.crs = site.crs};
    UnreadTags unread;
    for (const DrivableWay& way : ways) {
      int part = 0;
      const auto report = [&](const char* code, const std::string& what, Vec2 where) {
        if (findings && contains(site.area, where))
          findings->push_back({Severity::warning, code, fmt::format("way {}: {}", way.id, what), where.x, where.y});
      };
      for (const NodeRun& run : located_runs(way, places, area_lonlat, site_from_lonlat, report))
        for (const auto& piece : clip_line(run.line, site.area)) {
          RoadPath road = make_path(way, part, run, piece);
          if (road.nodes.back().s_m < min_piece_m) continue;
          for (const std::string& tag : part == 0 ? way.attributes.odd : std::vector<std::string>{})
            report("osm.odd_tag",
                   fmt::format("{} is no number above 0, took {:.1f} m as the width", tag, way.attributes.width_m),
                   road.nodes[road.nodes.size() / 2].p);
          for (const std::string& what : part == 0 ? way.attributes.doubts : std::vector<std::string>{})
            report("osm.lane_tags", what, road.nodes[road.nodes.size() / 2].p);
          if (part == 0)
            for (const auto& [tag, reason] : way.attributes.unread)
              unread.add(tag, reason, road.nodes[road.nodes.size() / 2].p);
          roads.paths.push_back(std::move(road));
          ++part;
        }
    }
    roads.restrictions = read_restrictions(path);
    roads.signs = places.signs(ways);
    add_unread_of_nodes(places, roads, unread);
    if (findings) unread.report(*findings);
    widen_at(places.turning_places(), site.area, roads);
    if (ways.empty())
      throw InputError(path.string(),
                       "has no drivable ways (highway=motorway ... service, track, raceway); is it the right extract?");
    if (roads.paths.empty())
      throw InputError(
          path.string(),
          fmt::format("has no roads in the area: its roads lie in {}, the area is {}; take another extract or area",
                      describe_lonlat(places.bounds()), describe_lonlat(area_lonlat)));
    return roads;
  });
}

}  // namespace orthodrive::io
