// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/join_places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/segment.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

constexpr double one_place_m = 0.02;     // two steps of OSM's coordinates (1e-7 degrees)
constexpr double near_vertex_m = 1.0;    // a vertex so near to an end is the junction
constexpr double own_reach_m = 20.0;     // nearer along the path, its end and its side are one place
constexpr double parallel_cos = 0.9659;  // 15 degrees: no side road comes in so flat

struct PlacedNode {
  std::size_t path = 0, node = 0;
};

bool is_path_end(const RoadPath& path, std::size_t node) { return node == 0 || node + 1 == path.nodes.size(); }

/// Names of nodes that became others.
class NodeNames {
 public:
  [[nodiscard]] std::int64_t of(std::int64_t id) const {
    for (auto at = names_.find(id); at != names_.end(); at = names_.find(id)) id = at->second;  // never in a circle
    return id;
  }
  void rename(std::int64_t from, std::int64_t to) {
    const std::int64_t first = of(from), last = of(to);
    if (first != last) names_[first] = last;
  }
  void apply(RoadNetwork& roads) const {
    if (names_.empty()) return;
    for (RoadPath& path : roads.paths)
      for (RoadNode& node : path.nodes) node.osm_node = of(node.osm_node);
    for (TurnRestriction& restriction : roads.restrictions) restriction.via_node = of(restriction.via_node);
    for (NodeSign& sign : roads.signs) sign.osm_node = of(sign.osm_node);
    std::ranges::stable_sort(roads.signs, sign_before);
    const auto same = [](const NodeSign& a, const NodeSign& b) { return !sign_before(a, b) && !sign_before(b, a); };
    roads.signs.erase(std::unique(roads.signs.begin(), roads.signs.end(), same), roads.signs.end());
  }

 private:
  std::unordered_map<std::int64_t, std::int64_t> names_;
};

// ---- nodes in one place

std::vector<PlacedNode> nodes_with_ids(const RoadNetwork& roads) {
  std::vector<PlacedNode> nodes;
  for (std::size_t p = 0; p < roads.paths.size(); ++p)
    for (std::size_t n = 0; n < roads.paths[p].nodes.size(); ++n)
      if (is_osm_node(roads.paths[p].nodes[n].osm_node)) nodes.push_back({p, n});
  return nodes;
}

bool may_be_one(const RoadNetwork& roads, const PlacedNode& a, const PlacedNode& b) {
  const RoadPath &pa = roads.paths[a.path], &pb = roads.paths[b.path];
  if (a.path == b.path && (a.node + 1 == b.node || b.node + 1 == a.node)) return false;  // a short segment
  return pa.layer == pb.layer || (is_path_end(pa, a.node) && is_path_end(pb, b.node));
}

void report_one_place(const std::vector<std::int64_t>& ids, Vec2 where, Findings& findings) {
  constexpr std::size_t most_named = 4;
  std::string names;
  for (std::size_t i = 0; i < std::min(ids.size(), most_named); ++i)
    names += fmt::format("{}{}", i == 0 ? "" : ", ", ids[i]);
  if (ids.size() > most_named) names += fmt::format(" and {} more", ids.size() - most_named);
  findings.push_back(
      {Severity::info, "osm.nodes_in_one_place",
       fmt::format("nodes {} lie in one place and are taken for one junction; merge them in the map", names), where.x,
       where.y});
}

void join_nodes_in_one_place(RoadNetwork& roads, Findings& findings) {
  const std::vector<PlacedNode> nodes = nodes_with_ids(roads);
  const auto node_at = [&](const PlacedNode& at) -> RoadNode& { return roads.paths[at.path].nodes[at.node]; };
  std::vector<Box2> boxes;
  std::unordered_map<std::int64_t, std::size_t> first_of_id;  // the first of `nodes` with that id
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    boxes.push_back(bounds_of({node_at(nodes[i]).p}));
    first_of_id.emplace(node_at(nodes[i]).osm_node, i);
  }
  const SpatialIndex index(boxes);
  DisjointSets sets(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (const std::uint32_t k : index.near(node_at(nodes[i]).p, one_place_m)) {
      const RoadNode &a = node_at(nodes[i]), &b = node_at(nodes[k]);
      if (k <= i || a.osm_node == b.osm_node || distance(a.p, b.p) > one_place_m) continue;
      if (may_be_one(roads, nodes[i], nodes[k])) sets.join(first_of_id.at(a.osm_node), first_of_id.at(b.osm_node));
    }
  NodeNames names;
  std::map<std::size_t, std::vector<std::int64_t>> places;  // the first node of a set, and the ids of all
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::int64_t id = node_at(nodes[i]).osm_node;
    if (first_of_id.at(id) != i) continue;
    const std::size_t first = sets.find(i);
    if (first == i) continue;
    const std::int64_t name = node_at(nodes[first]).osm_node;
    places.try_emplace(first, 1, name).first->second.push_back(id);
    names.rename(id, name);
  }
  for (const auto& [first, ids] : places) report_one_place(ids, node_at(nodes[first]).p, findings);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t first = sets.find(first_of_id.at(node_at(nodes[i]).osm_node));
    if (places.contains(first)) node_at(nodes[i]).p = node_at(nodes[first]).p;
  }
  names.apply(roads);
}

// ---- ends on a carriageway

struct CarriagewayPlace {
  std::size_t path = 0, segment = 0;
  double fraction = 0.0, distance_m = INFINITY;
  Vec2 p;
  bool is_parallel = false;
};

struct NewVertex {
  std::size_t path = 0, segment = 0;
  double fraction = 0.0;
  Vec2 p;
  std::int64_t osm_node = no_osm_node;
};

class EndJoiner {
 public:
  explicit EndJoiner(RoadNetwork& roads) : roads_(roads) {
    for (std::size_t p = 0; p < roads.paths.size(); ++p) {
      lines_.push_back(centerline(roads.paths[p]));
      s_m_.push_back(arc_lengths_m(lines_.back()));
      for (const RoadNode& node : roads.paths[p].nodes) {
        widest_m_ = std::max(widest_m_, node.width_m);
        if (is_osm_node(node.osm_node)) paths_at_[node.osm_node].push_back(p);
      }
    }
    index_ = SegmentIndex(lines_);
  }

  void run(Findings& findings) {
    for (std::size_t p = 0; p < roads_.paths.size(); ++p) {
      const std::vector<RoadNode>& nodes = roads_.paths[p].nodes;
      if (nodes.size() < 2 || nodes.front().p == nodes.back().p) continue;
      for (const std::size_t n : {std::size_t{0}, nodes.size() - 1})
        if (is_osm_node(nodes[n].osm_node) && paths_at_.at(nodes[n].osm_node).size() == 1) join_end({p, n}, findings);
    }
    apply();
  }

 private:
  void join_end(const PlacedNode& end, Findings& findings) {
    const std::optional<CarriagewayPlace> at = nearest(end);
    if (!at || meets_near(end, at->path)) return;
    const RoadNode& node = roads_.paths[end.path].nodes[end.node];
    const RoadPath &own = roads_.paths[end.path], &other = roads_.paths[at->path];
    const auto report = [&](Severity severity, const char* code, const char* what) {
      findings.push_back({severity, code,
                          fmt::format("way {}: its end (node {}) lies {:.1f} m from the middle of way {}, on its "
                                      "carriageway, without a common node: {}",
                                      own.osm_id, node.osm_node, at->distance_m, other.osm_id, what),
                          node.p.x, node.p.y});
    };
    if (at->is_parallel)
      return report(Severity::warning, "osm.end_on_road", "it runs along that road and is not joined; mend the map");
    if (attach(node.osm_node, *at)) report(Severity::info, "osm.end_joined", "joined there");
  }

  [[nodiscard]] Vec2 direction_at(const PlacedNode& end) const {
    const Polyline& line = lines_[end.path];
    return normalized(end.node == 0 ? line[0] - line[1] : line[end.node] - line[end.node - 1]);
  }

  [[nodiscard]] std::optional<CarriagewayPlace> nearest(const PlacedNode& end) const {
    const RoadPath& own = roads_.paths[end.path];
    const Vec2 p = own.nodes[end.node].p, along = direction_at(end);
    CarriagewayPlace best;
    for (const auto [path, k] : index_.near(p, 0.5 * widest_m_)) {
      const RoadPath& other = roads_.paths[path];
      if (other.layer != own.layer || other.bridge != own.bridge || other.tunnel != own.tunnel) continue;
      const Vec2 a = lines_[path][k], ab = lines_[path][k + 1] - a;
      const double fraction = share_along(a, lines_[path][k + 1], p);
      const Vec2 q = a + ab * fraction;
      const double s = s_m_[path][k] + fraction * (s_m_[path][k + 1] - s_m_[path][k]);
      if (path == end.path && std::abs(s - s_m_[path][end.node]) < own_reach_m) continue;
      const double half_m = 0.5 * std::lerp(other.nodes[k].width_m, other.nodes[k + 1].width_m, fraction);
      const double distance_m = distance(p, q);
      if (distance_m > half_m || distance_m >= best.distance_m) continue;
      const bool beyond_end = (k == 0 && fraction == 0.0) || (k + 2 == lines_[path].size() && fraction == 1.0);
      best = {path, k, fraction, distance_m, q, !beyond_end && std::abs(dot(normalized(ab), along)) > parallel_cos};
    }
    if (!std::isfinite(best.distance_m)) return std::nullopt;
    return best;
  }

  /// Whether the path of an end shares a node with `other` near the end: a stub, or an island.
  [[nodiscard]] bool meets_near(const PlacedNode& end, std::size_t other) const {
    const std::vector<RoadNode>& nodes = roads_.paths[end.path].nodes;
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      if (n == end.node || !is_osm_node(nodes[n].osm_node)) continue;
      if (std::abs(s_m_[end.path][n] - s_m_[end.path][end.node]) > own_reach_m || other == end.path) continue;
      if (std::ranges::find(paths_at_.at(nodes[n].osm_node), other) != paths_at_.at(nodes[n].osm_node).end())
        return true;
    }
    return false;
  }

  /// False where the other end has joined this one already.
  bool attach(std::int64_t id, const CarriagewayPlace& at) {
    const RoadNode &a = roads_.paths[at.path].nodes[at.segment], &b = roads_.paths[at.path].nodes[at.segment + 1];
    const RoadNode& nearer = distance(a.p, at.p) <= distance(b.p, at.p) ? a : b;
    if (is_osm_node(nearer.osm_node) && distance(nearer.p, at.p) <= near_vertex_m)
      return take_place(id, nearer.osm_node, nearer.p);
    for (const NewVertex& vertex : vertices_)
      if (vertex.path == at.path && distance(vertex.p, at.p) <= near_vertex_m)
        return take_place(id, vertex.osm_node, vertex.p);
    vertices_.push_back({at.path, at.segment, at.fraction, at.p, id});
    place_of_[names_.of(id)] = at.p;
    return true;
  }
  bool take_place(std::int64_t id, std::int64_t target, Vec2 p) {
    const std::int64_t name = names_.of(target);
    if (name == names_.of(id)) return false;
    p = place_of_.try_emplace(name, p).first->second;
    names_.rename(id, target);
    return true;
  }

  void apply() {
    // From the back of each path, so that places before stay.
    std::stable_sort(vertices_.begin(), vertices_.end(), [](const NewVertex& a, const NewVertex& b) {
      if (a.path != b.path) return a.path < b.path;
      return a.segment != b.segment ? a.segment > b.segment : a.fraction > b.fraction;
    });
    for (const NewVertex& vertex : vertices_) {
      std::vector<RoadNode>& nodes = roads_.paths[vertex.path].nodes;
      RoadNode node = vertex.fraction < 0.5 ? nodes[vertex.segment] : nodes[vertex.segment + 1];
      node.p = vertex.p, node.osm_node = vertex.osm_node;
      node.width_m = std::lerp(nodes[vertex.segment].width_m, nodes[vertex.segment + 1].width_m, vertex.fraction);
      nodes.insert(nodes.begin() + static_cast<std::ptrdiff_t>(vertex.segment) + 1, node);
    }
    names_.apply(roads_);
    for (RoadPath& path : roads_.paths)
      for (RoadNode& node : path.nodes)
        if (const auto at = place_of_.find(node.osm_node); at != place_of_.end()) node.p = at->second;
  }

  RoadNetwork& roads_;
  std::vector<Polyline> lines_;
  std::vector<std::vector<double>> s_m_;
  double widest_m_ = 0.0;
  std::unordered_map<std::int64_t, std::vector<std::size_t>> paths_at_;
  SegmentIndex index_;
  std::vector<NewVertex> vertices_;
  NodeNames names_;
  std::unordered_map<std::int64_t, Vec2> place_of_;
};

}  // namespace

void join_places(RoadNetwork& roads, Findings& findings) {
  join_nodes_in_one_place(roads, findings);
  EndJoiner(roads).run(findings);
  for (RoadPath& path : roads.paths)
    for (std::size_t n = 1; n < path.nodes.size(); ++n)
      path.nodes[n].s_m = path.nodes[n - 1].s_m + distance(path.nodes[n - 1].p, path.nodes[n].p);
}

}  // namespace orthodrive
