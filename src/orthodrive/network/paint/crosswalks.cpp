// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/crosswalks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/network/junctions/road_cover.hpp"
#include "roadquery/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Road;
using roadquery::RoadMap;

constexpr double off_line_m = 4.0;  // roads give way to each other and turn into side roads by less
constexpr double aligned = 0.87;    // cosine: a road that runs 30 degrees off is another one
constexpr double part_m = 8.0;

/// A place on a road's reference line.
struct Foot {
  std::size_t road = 0;
  double s = 0.0, t = 0.0;
};

/// Which reference lines run near a place.
class LineFinder {
 public:
  explicit LineFinder(const RoadMap& map) : map_(map) {
    std::vector<Box2> boxes;
    for (std::size_t i = 0; i < map.roads.size(); ++i) {
      const Road& road = map.roads[i];
      const int count = std::max(1, static_cast<int>(std::ceil(road.length / part_m)));
      for (int k = 0; k < count; ++k) {
        const double s = road.length * (k + 0.5) / count, half = 0.5 * road.length / count;
        const auto q = roadquery::reference_point(road, s);
        parts_.push_back({i, s});
        boxes.push_back({q.x - half, q.y - half, q.x + half, q.y + half});
      }
    }
    index_ = SpatialIndex(boxes);
  }

  /// The nearest line that runs along `direction` or against it; of two as near the first.
  template <typename Accept>
  [[nodiscard]] std::optional<Foot> find(Vec2 p, Vec2 direction, const Accept& accept) const {
    std::optional<Foot> best;
    for (const std::uint32_t i : index_.near(p, off_line_m)) {
      const Road& road = map_.roads[parts_[i].road];
      if (!accept(road)) continue;
      double s = parts_[i].s;
      roadquery::PlanPoint q;
      for (int step = 0; step < 4; ++step) {
        q = roadquery::reference_point(road, s);
        s = std::clamp(s + (p.x - q.x) * std::cos(q.hdg) + (p.y - q.y) * std::sin(q.hdg), 0.0, road.length);
      }
      q = roadquery::reference_point(road, s);
      const Vec2 along{std::cos(q.hdg), std::sin(q.hdg)}, off = p - Vec2{q.x, q.y};
      constexpr double beyond_m = 0.5;
      if (std::abs(dot(along, direction)) < aligned || std::abs(dot(off, along)) > beyond_m) continue;
      const double t = cross(along, off);
      if (std::abs(t) > off_line_m || (best && std::abs(t) >= std::abs(best->t) - 1e-3)) continue;
      best = Foot{parts_[i].road, s, t};
    }
    return best;
  }

 private:
  struct Part {
    std::size_t road;
    double s;
  };
  const RoadMap& map_;
  std::vector<Part> parts_;
  SpatialIndex index_;
};

const char* subtype_of(NodeSignKind kind) {
  return kind == NodeSignKind::zebra ? "zebra" : kind == NodeSignKind::signal_crossing ? "pedestrian" : "virtual";
}

void add_crosswalk(Road& road, double s, double right_t, double left_t, const char* subtype) {
  const double half = 0.5 * crosswalk_m;
  if (road.length < crosswalk_m || left_t - right_t < 1.0) return;
  s = std::clamp(s, half, road.length - half);
  road.objects.push_back({.type = "crosswalk",
                          .subtype = subtype,
                          .s = s,
                          .t = 0.5 * (left_t + right_t),
                          .length = crosswalk_m,
                          .width = left_t - right_t});
  road.objects.back().outline = {{s - half, right_t}, {s + half, right_t}, {s + half, left_t}, {s - half, left_t}};
}

/// Whether a crosswalk there ends with the road or before.
bool has_room(const RoadMap& map, const Foot& foot) {
  constexpr double little_m = 0.5;  // that it may be moved
  const double half = 0.5 * crosswalk_m - little_m;
  return foot.s >= half && foot.s <= map.roads[foot.road].length - half;
}

Vec2 direction_at(const RoadPath& path, std::size_t node) {
  const std::size_t last = path.nodes.size() - 1;
  return normalized(path.nodes[std::min(node + 1, last)].p - path.nodes[node == 0 ? 0 : node - 1].p);
}

}  // namespace

void add_crosswalks(const NetworkPlan& plan, const std::vector<int>& straight, RoadMap& map) {
  std::map<std::int64_t, NodeSignKind> crossings;
  for (const NodeSign& sign : plan.roads.signs)
    if (sign.kind >= NodeSignKind::zebra) crossings.emplace(sign.osm_node, sign.kind);
  if (crossings.empty()) return;
  std::set<std::int64_t> done;
  for (const VertexIndex v : plan.topology.vertices.indices())
    if (plan.topology.vertices[v].is_junction()) done.insert(plan.topology.vertices[v].osm_node);
  const LineFinder finder(map);
  for (const RoadPath& path : plan.roads.paths) {
    for (std::size_t i = 0; i < path.nodes.size(); ++i) {
      const RoadNode& node = path.nodes[i];
      const auto crossing = crossings.find(node.osm_node);
      if (!is_osm_node(node.osm_node) || crossing == crossings.end() || !done.insert(node.osm_node).second) continue;
      const auto find = [&](const auto& accept) {
        return finder.find(node.p, direction_at(path, i), [&](const Road& road) {
          return road.layer == path.layer && !road.sections.empty() && accept(road);
        });
      };
      const std::string way = std::to_string(path.osm_id);
      auto foot = find([&](const Road& road) { return road.junction < 0 && road.osm_id == way; });
      if (!foot || !has_room(map, *foot)) {
        const auto inside = find([&](const Road& road) { return std::ranges::binary_search(straight, road.id); });
        if (inside && (!foot || has_room(map, *inside))) foot = inside;
      }
      if (!foot) foot = find([](const Road& road) { return road.junction >= 0; });
      if (!foot) continue;
      Road& road = map.roads[foot->road];
      const roadquery::Edges edges = road.junction < 0
                                         ? carriageway_edges(road, foot->s)
                                         : roadquery::Edges{foot->t + 0.5 * node.width_m, foot->t - 0.5 * node.width_m};
      add_crosswalk(road, foot->s, edges.right_t, edges.left_t, subtype_of(crossing->second));
    }
  }
}

}  // namespace orthodrive::network
