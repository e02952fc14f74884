// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/crosswalks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/network/junctions/road_cover.hpp"
#include "orthodrive/network/paint/line_finder.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Road;
using roadquery::RoadMap;

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
bool has_room(const RoadMap& map, const RoadFoot& foot) {
  constexpr double little_m = 0.5;  // that it may be moved
  const double half = 0.5 * crosswalk_m - little_m;
  return foot.s >= half && foot.s <= map.roads[foot.road].length - half;
}

}  // namespace

void add_crosswalks(const NetworkPlan& plan, const std::vector<int>& straight, RoadMap& map) {
  std::map<std::int64_t, NodeSignKind> crossings;
  for (const NodeSign& sign : plan.roads.signs)
    if (is_crossing(sign.kind)) crossings.emplace(sign.osm_node, sign.kind);
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
