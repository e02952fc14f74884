// SPDX-License-Identifier: Apache-2.0
// Roads of an OSM file. Two passes: first the drivable ways, then the places of their nodes, so that an extract of a
// country needs memory for its roads only.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <osmium/osm/node.hpp>
#include <osmium/osm/way.hpp>
#include <set>
#include <span>
#include <string_view>

#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/osm/built_up_areas.hpp"
#include "orthodrive/io/osm/osm_restrictions.hpp"
#include "orthodrive/io/osm/osm_road_ids.hpp"
#include "orthodrive/io/osm/osm_structure_tags.hpp"
#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/io/osm/tag_rules.hpp"
#include "orthodrive/io/osm/turning_places.hpp"
#include "orthodrive/io/osm/via_ways.hpp"
#include "orthodrive/io/support/clip_line.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/io/support/osm_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive::io {
namespace {
using Files = std::vector<std::filesystem::path>;

template <typename F>
void for_each_file(const Files& files, F&& read) {
  for (const std::filesystem::path& path : files) with_osm_errors(path, [&] { read(path); });
}

struct DrivableWay {
  std::int64_t id = 0;
  osmium::object_version_type version = 0;
  WayAttributes attributes;
  std::vector<std::int64_t> nodes;
  Ring lonlat;  ///< of the nodes, where the way itself tells (`out geom`); NaN else
};

void read_ways(const std::filesystem::path& path, std::vector<DrivableWay>& ways) {
  read_osm_buffers(path, osmium::osm_entity_bits::way, [&](const osmium::memory::Buffer& buffer) {
    for (const osmium::Way& way : buffer.select<osmium::Way>()) {
      if (!has_road_tags(way.tags())) continue;
      DrivableWay road{way.id(), way.version(), way_attributes(tags_of(way.tags())), {}, {}};
      if (!road.attributes.omitted && !is_drivable(road.attributes.path.highway)) continue;
      for (const osmium::NodeRef& node : way.nodes())
        road.nodes.push_back(road_node(node.ref())), road.lonlat.push_back(lonlat_of(node.location()));
      if (road.attributes.reversed)
        std::reverse(road.nodes.begin(), road.nodes.end()), std::reverse(road.lonlat.begin(), road.lonlat.end());
      ways.push_back(std::move(road));
    }
  });
}

/// Takes `other`, a half of the same way from another extract, into `way` where they overlap: the one holds the other,
/// or the nodes at the end of the one are those at the beginning of the other. False where they do not.
bool join_halves(DrivableWay& way, const DrivableWay& other) {
  const auto holds = [](const DrivableWay& a, const DrivableWay& b) {
    return std::search(a.nodes.begin(), a.nodes.end(), b.nodes.begin(), b.nodes.end()) != a.nodes.end();
  };
  if (other.nodes.empty() || holds(way, other)) return true;
  if (way.nodes.empty() || holds(other, way)) {
    way.nodes = other.nodes, way.lonlat = other.lonlat;
    return true;
  }
  const auto append = [](DrivableWay& front, const DrivableWay& back) {
    for (std::size_t n = std::min(front.nodes.size(), back.nodes.size()) - 1; n > 0; --n) {
      if (!std::equal(front.nodes.end() - static_cast<std::ptrdiff_t>(n), front.nodes.end(), back.nodes.begin()))
        continue;
      front.nodes.insert(front.nodes.end(), back.nodes.begin() + static_cast<std::ptrdiff_t>(n), back.nodes.end());
      front.lonlat.insert(front.lonlat.end(), back.lonlat.begin() + static_cast<std::ptrdiff_t>(n), back.lonlat.end());
      return true;
    }
    return false;
  };
  if (append(way, other)) return true;
  DrivableWay front = other;
  if (!append(front, way)) return false;
  way.nodes = std::move(front.nodes), way.lonlat = std::move(front.lonlat);
  return true;
}

/// Each way once, by id: the latest version, of equal ones the first. Halves of a way that extracts cut are joined;
/// those without a common node stay beside each other.
std::vector<DrivableWay> unique_ways(std::vector<DrivableWay> ways) {
  std::stable_sort(ways.begin(), ways.end(), [](const DrivableWay& a, const DrivableWay& b) {
    return a.id != b.id ? a.id < b.id : a.version > b.version;
  });
  std::vector<DrivableWay> unique;
  for (DrivableWay& way : ways) {
    const auto same =
        std::find_if(unique.rbegin(), unique.rend(), [&](const DrivableWay& w) { return w.id != way.id; });
    const auto first = same.base();  // of the ways with this id
    if (first != unique.end() && first->version != way.version) continue;
    if (std::none_of(first, unique.end(), [&](DrivableWay& known) { return join_halves(known, way); }))
      unique.push_back(std::move(way));
  }
  return unique;
}

/// Where the nodes of the ways lie, in degrees; NaN for nodes that the files lack.
class NodePlaces {
 public:
  explicit NodePlaces(const std::vector<DrivableWay>& ways) {
    for (const DrivableWay& way : ways) ids_.insert(ids_.end(), way.nodes.begin(), way.nodes.end());
    std::sort(ids_.begin(), ids_.end());
    ids_.erase(std::unique(ids_.begin(), ids_.end()), ids_.end());
    nodes_.resize(ids_.size());
    for (const DrivableWay& way : ways)
      for (std::size_t i = 0; i < way.nodes.size(); ++i)
        if (!std::isnan(way.lonlat[i].x)) nodes_[index_of(way.nodes[i])].lonlat = way.lonlat[i];
  }
  /// The latest version of a node counts, of equal ones the first.
  void read(const std::filesystem::path& path) {
    read_osm_buffers(path, osmium::osm_entity_bits::node, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Node& node : buffer.select<osmium::Node>()) {
        const std::int64_t id = road_node(node.id());
        const auto it = std::lower_bound(ids_.begin(), ids_.end(), id);
        if (it == ids_.end() || *it != id || !node.location().valid()) continue;
        Known& known = nodes_[static_cast<std::size_t>(it - ids_.begin())];
        if (known.is_read && known.version >= node.version()) continue;
        known = {lonlat_of(node.location()), node.version(), true, {}, {}, {}};
        if (!node.tags().empty()) read_tags(id, tags_of(node.tags()), known);
      }
    });
  }
  [[nodiscard]] Vec2 lonlat(std::int64_t id) const { return nodes_[index_of(id)].lonlat; }
  /// NaN, too, for a node that no way has.
  [[nodiscard]] Vec2 known_lonlat(std::int64_t id) const {
    const std::size_t i = index_of(id);
    return i < ids_.size() && ids_[i] == id ? nodes_[i].lonlat : Known{}.lonlat;
  }
  /// Of the nodes of the ways, sorted; their directions are the paths'.
  [[nodiscard]] std::vector<NodeSign> signs(const std::vector<DrivableWay>& ways) const {
    std::set<std::int64_t> turned;
    for (const DrivableWay& way : ways)
      if (way.attributes.reversed) turned.insert(way.nodes.begin(), way.nodes.end());
    std::vector<NodeSign> result;
    for (const Known& node : nodes_) result.insert(result.end(), node.signs.begin(), node.signs.end());
    for (NodeSign& sign : result)
      if (turned.contains(sign.osm_node)) sign.direction = -sign.direction;
    std::ranges::stable_sort(result, sign_before);
    return result;
  }
  [[nodiscard]] std::vector<TurningPlace> turning_places() const {
    std::vector<TurningPlace> places;
    for (const Known& node : nodes_)
      if (node.turning) places.push_back(*node.turning);
    return places;
  }
  /// Tags of the node that are not read; empty for a node that no way has.
  [[nodiscard]] std::span<const UnreadTag> unread(std::int64_t id) const {
    const std::size_t i = index_of(id);
    return i < ids_.size() && ids_[i] == id ? std::span<const UnreadTag>(nodes_[i].unread)
                                            : std::span<const UnreadTag>();
  }
  /// Of the nodes that have a place; empty where none has.
  [[nodiscard]] Ring known() const {
    Ring known;
    for (const Known& node : nodes_)
      if (!std::isnan(node.lonlat.x)) known.push_back(node.lonlat);
    return known;
  }

 private:
  struct Known {
    Vec2 lonlat{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    osmium::object_version_type version = 0;
    bool is_read = false;
    std::vector<NodeSign> signs;
    std::optional<TurningPlace> turning;
    std::vector<UnreadTag> unread;
  };
  static void read_tags(std::int64_t id, const OsmTags& tags, Known& known) {
    known.signs = node_signs(id, tags);
    known.turning = turning_place(id, tags);
    known.unread = unread_tags(tags, TaggedObject::node);
  }
  [[nodiscard]] std::size_t index_of(std::int64_t id) const {
    return static_cast<std::size_t>(std::lower_bound(ids_.begin(), ids_.end(), id) - ids_.begin());
  }
  std::vector<std::int64_t> ids_;
  std::vector<Known> nodes_;
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
void add_unread_of_nodes(const NodePlaces& places, const std::vector<RoadPath>& paths, UnreadTags& unread) {
  std::map<std::int64_t, Vec2> place_of;
  for (const RoadPath& path : paths)
    for (const RoadNode& node : path.nodes)
      if (node.osm_node != no_osm_node) place_of.emplace(node.osm_node, node.p);
  for (const auto& [id, place] : place_of)
    for (const UnreadTag& tag : places.unread(id)) unread.add(tag.tag, tag.reason, place);
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
                          .osm_node = point.vertex ? run.nodes[*point.vertex] : no_osm_node,
                          .s_m = s_m,
                          .width_m = way.attributes.width_m});
  }
  return path;
}

/// Throws where nothing was found: says why, and where the roads of the files lie.
void check_roads(const std::string& names, const std::vector<DrivableWay>& ways, const NodePlaces& places,
                 const Box2& area_lonlat, const RoadNetwork& roads) {
  if (std::ranges::all_of(ways, [](const DrivableWay& way) { return way.attributes.omitted.has_value(); }))
    throw InputError(names,
                     "has no drivable ways (highway=motorway ... service, track, raceway); is it the right extract?");
  const Ring known = places.known();
  if (known.empty())
    throw InputError(names,
                     "has roads but no nodes, so that nothing tells where they lie; ask Overpass for them with "
                     "`out body; >; out skel qt;` or `out geom;`");
  if (roads.paths.empty())
    throw InputError(
        names,
        fmt::format("has no roads in the area: its roads lie in {}, the area is {}; take another extract or area",
                    describe_lonlat(bounds_of(known)), describe_lonlat(area_lonlat)));
}

/// Cuts ways at the area and where nodes are missing, and reports what is odd about them.
class PathMaker {
 public:
  PathMaker(const SiteFrame& site, const NodePlaces& places, Findings* findings)
      : site_(site),
        places_(places),
        findings_(findings),
        site_from_lonlat_(Crs{"EPSG:4326"}, site.crs),
        area_lonlat_(lonlat_bounds(site.area.outer, site.crs)) {}

  /// Parts of one way are counted over all that belong to it.
  void add(const DrivableWay& way, std::vector<RoadPath>& paths) {
    constexpr double min_piece_m = 0.1;  // what is left where a way only touches the border
    if (way.id != id_) part_ = 0, id_ = way.id;
    const auto report = [&](const char* code, const std::string& what, Vec2 where) {
      push(way, Severity::warning, code, what, where);
    };
    const auto& omitted = way.attributes.omitted;
    const auto quiet = [](const char*, const std::string&, Vec2) {};
    const std::vector<NodeRun> runs = omitted ? located_runs(way, places_, area_lonlat_, site_from_lonlat_, quiet)
                                              : located_runs(way, places_, area_lonlat_, site_from_lonlat_, report);
    for (const NodeRun& run : runs)
      for (const auto& piece : clip_line(run.line, site_.area)) {
        RoadPath road = make_path(way, part_, run, piece);
        if (road.nodes.back().s_m < min_piece_m) continue;
        const Vec2 middle = road.nodes[road.nodes.size() / 2].p;
        if (omitted) return push(way, omitted->severity, omitted->code, omitted->why, middle);
        if (part_ == 0) {
          for (const std::string& tag : way.attributes.odd)
            report("osm.odd_tag",
                   fmt::format("{} is no number above 0, took {:.1f} m as the width", tag, way.attributes.width_m),
                   middle);
          for (const std::string& what : way.attributes.doubts) report("osm.lane_tags", what, middle);
          for (const auto& [tag, reason] : way.attributes.unread) unread_.add(tag, reason, middle);
        }
        paths.push_back(std::move(road));
        ++part_;
      }
  }
  [[nodiscard]] const Box2& area_lonlat() const { return area_lonlat_; }
  /// Reports the tags that were met and are not read, of the ways and of the nodes on the roads.
  void report_unread(const std::vector<RoadPath>& paths) {
    if (!findings_) return;
    add_unread_of_nodes(places_, paths, unread_);
    unread_.report(*findings_);
  }

  /// Of roads in the area alone: where one turns, else where the way begins.
  void report_restriction(const UnreadRestriction& restriction, const std::vector<DrivableWay>& ways) {
    if (!findings_) return;
    std::vector<std::int64_t> nodes;
    bool has_road = false;
    for (const auto* ids : {&restriction.from_ways, &restriction.via_ways})
      for (const std::int64_t id : *ids) {
        const auto way = std::ranges::lower_bound(ways, id, {}, &DrivableWay::id);
        if (way == ways.end() || way->id != id) continue;
        has_road = true;
        nodes.insert(ids == &restriction.via_ways ? nodes.begin() : nodes.end(), way->nodes.begin(), way->nodes.end());
      }
    if (!has_road) return;
    nodes.insert(nodes.begin(), restriction.via_nodes.begin(), restriction.via_nodes.end());
    for (const std::int64_t node : nodes) {
      const Vec2 p = places_.known_lonlat(node);
      if (std::isnan(p.x) || !area_lonlat_.contains(p)) continue;
      const Vec2 where = site_from_lonlat_.target_from_source(p);
      if (!contains(site_.area, where)) continue;
      findings_->push_back({restriction.severity, "osm.restriction_not_read",
                            fmt::format("relation {}: {}", restriction.relation, restriction.why), where.x, where.y});
      return;
    }
  }

 private:
  void push(const DrivableWay& way, Severity severity, const char* code, const std::string& what, Vec2 where) {
    if (findings_ && contains(site_.area, where))
      findings_->push_back({severity, code, fmt::format("way {}: {}", way.id, what), where.x, where.y});
  }

  const SiteFrame& site_;
  const NodePlaces& places_;
  Findings* findings_;
  CoordinateTransform site_from_lonlat_;
  Box2 area_lonlat_;
  UnreadTags unread_;
  std::int64_t id_ = 0;
  int part_ = 0;
};

/// From south-west to north-east by the first place that differs, so that numbers of objects, which editors and
/// extracts choose, decide nothing. Halves of one way stay together.
std::vector<const DrivableWay*> by_place(const std::vector<DrivableWay>& ways, const NodePlaces& places) {
  const auto line_of = [&](const DrivableWay& way) {
    std::vector<std::pair<double, double>> line;
    line.reserve(way.nodes.size());
    for (const std::int64_t node : way.nodes)
      if (const Vec2 p = places.lonlat(node); !std::isnan(p.x)) line.emplace_back(p.x, p.y);
    return line;
  };
  std::vector<const DrivableWay*> ordered;
  std::map<std::int64_t, std::vector<std::pair<double, double>>> first_of;
  for (const DrivableWay& way : ways) {
    ordered.push_back(&way);
    auto line = line_of(way);
    const auto [it, is_new] = first_of.try_emplace(way.id, line);
    if (!is_new) it->second = std::min(it->second, line);
  }
  std::ranges::stable_sort(ordered, [&](const DrivableWay* a, const DrivableWay* b) {
    if (a->id == b->id) return line_of(*a) < line_of(*b);
    const auto &of_a = first_of.at(a->id), &of_b = first_of.at(b->id);
    return of_a != of_b ? of_a < of_b : a->id < b->id;
  });
  return ordered;
}

/// Whether cars can leave the node along the way.
bool leads_away(const DrivableWay& way, std::int64_t node) {
  const RoadPath& path = way.attributes.path;
  if (way.attributes.omitted || !path.use.empty()) return false;
  for (std::size_t i = 0; i < way.nodes.size(); ++i)
    if (way.nodes[i] == node && (i + 1 < way.nodes.size() || path.oneway != Oneway::forward)) return true;
  return false;
}

UnreadRestriction unread_of(const ReadRestriction& restriction, std::string why) {
  const TurnRestriction& turn = restriction.turn;
  std::vector<std::int64_t> via_nodes;
  if (turn.via_ways.empty()) via_nodes.push_back(turn.via_node);
  return {restriction.relation, Severity::warning,    std::move(why),
          {turn.from_way},      std::move(via_nodes), turn.via_ways};
}

/// Restrictions over ways get their order; those that cannot be driven are unread.
void order_restrictions(const std::vector<DrivableWay>& ways, OsmRestrictions& restrictions) {
  std::map<std::int64_t, TurningWay> turning;
  const FindTurningWay find = [&](std::int64_t id) -> const TurningWay* {
    if (const auto known = turning.find(id); known != turning.end()) return &known->second;
    const auto way = std::ranges::lower_bound(ways, id, {}, &DrivableWay::id);
    if (way == ways.end() || way->id != id || way->attributes.omitted) return nullptr;
    TurningWay found{way->nodes, way->attributes.path.oneway == Oneway::forward};
    for (auto half = way + 1; half != ways.end() && half->id == id; ++half)  // of one that extracts have cut
      found.nodes.insert(found.nodes.end(), half->nodes.begin(), half->nodes.end());
    return &turning.emplace(id, std::move(found)).first->second;
  };
  std::vector<ReadRestriction> ordered;
  for (ReadRestriction& restriction : restrictions.read) {
    std::string why;
    if (!restriction.turn.via_ways.empty()) why = order_via_ways(restriction.turn, find);
    if (why.empty())
      ordered.push_back(std::move(restriction));
    else
      restrictions.unread.push_back(
          unread_of(restriction, fmt::format("{} over ways is left out: {}", printable(restriction.value), why)));
  }
  restrictions.read = std::move(ordered);
}

/// The only turn that a relation allows closes all others: not if that one is none.
void leave_out_impossible(const std::vector<DrivableWay>& ways, OsmRestrictions& restrictions) {
  const auto is_possible = [&](const ReadRestriction& restriction) {
    const auto way = std::ranges::lower_bound(ways, restriction.turn.to_way, {}, &DrivableWay::id);
    const bool closes_others = restriction.turn.only && restriction.turn.via_ways.empty();
    return !closes_others || std::any_of(way, ways.end(), [&, is_same = true](const DrivableWay& part) mutable {
      is_same = is_same && part.id == restriction.turn.to_way;  // halves of a way stand beside each other
      return is_same && leads_away(part, restriction.turn.via_node);
    });
  };
  const auto impossible = std::stable_partition(restrictions.read.begin(), restrictions.read.end(), is_possible);
  for (auto it = impossible; it != restrictions.read.end(); ++it)
    restrictions.unread.push_back(unread_of(
        *it, fmt::format("only_* to way {}, along which no car leaves that node, is left out", it->turn.to_way)));
  restrictions.read.erase(impossible, restrictions.read.end());
}

/// Share of the length of a path, by a sample every 25 m.
double share_in(const BuiltUpAreas& areas, const RoadPath& path) {
  constexpr double sample_m = 25.0;
  double inside_m = 0.0;
  for (std::size_t i = 1; i < path.nodes.size(); ++i) {
    const Vec2 a = path.nodes[i - 1].p, b = path.nodes[i].p;
    const double length_m = distance(a, b);
    const int samples = std::max(1, static_cast<int>(std::lround(length_m / sample_m)));
    for (int k = 0; k < samples; ++k)
      if (areas.holds(a + (b - a) * ((k + 0.5) / samples))) inside_m += length_m / samples;
  }
  return inside_m / path.nodes.back().s_m;
}

/// Of roads of which nothing says whether they lie in a town: whether most of their length lies in built-up areas.
/// Nothing where the map has no such areas.
void place_in_towns(const Files& files, const SiteFrame& site, std::vector<RoadPath>& paths) {
  const auto is_open = [](const RoadPath& path) { return path.speed_limit_kmh == 0.0 && path.speed_context.empty(); };
  if (std::ranges::none_of(paths, is_open)) return;
  const BuiltUpAreas areas(files, site);
  if (areas.empty()) return;
  for (RoadPath& path : paths) {
    if (!is_open(path)) continue;
    path.speed_context = share_in(areas, path) >= 0.5 ? "urban" : "rural";
  }
}

}  // namespace

RoadNetwork read_osm_roads(const std::vector<std::filesystem::path>& files, const SiteFrame& site, Findings* findings) {
  std::vector<DrivableWay> ways;
  for_each_file(files, [&](const std::filesystem::path& path) { read_ways(path, ways); });
  ways = unique_ways(std::move(ways));
  NodePlaces places(ways);
  for_each_file(files, [&](const std::filesystem::path& path) { places.read(path); });
  RoadNetwork roads{.crs = site.crs};
  PathMaker maker(site, places, findings);
  for (const DrivableWay* way : by_place(ways, places)) maker.add(*way, roads.paths);
  std::string names;
  for (const std::filesystem::path& path : files) names += (names.empty() ? "" : ", ") + path.string();
  check_roads(names, ways, places, maker.area_lonlat(), roads);
  OsmRestrictions restrictions = read_restrictions(files);
  order_restrictions(ways, restrictions);
  leave_out_impossible(ways, restrictions);
  for (const ReadRestriction& restriction : restrictions.read) roads.restrictions.push_back(restriction.turn);
  for (const UnreadRestriction& restriction : restrictions.unread) maker.report_restriction(restriction, ways);
  roads.signs = places.signs(ways);
  maker.report_unread(roads.paths);
  place_in_towns(files, site, roads.paths);
  widen_at(places.turning_places(), site.area, roads);
  return roads;
}

RoadNetwork read_osm_roads(const std::filesystem::path& path, const SiteFrame& site, Findings* findings) {
  return read_osm_roads(std::vector{path}, site, findings);
}

}  // namespace orthodrive::io
