// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/hindrances.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/model/roads/road_barriers.hpp"
#include "orthodrive/model/roads/traffic_calming.hpp"
#include "orthodrive/network/paint/line_finder.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Road;
using roadquery::RoadMap;

/// Across the carriageway, or as wide as it is in its middle.
roadquery::RoadObject object_across(const Road& road, const RoadFoot& foot, double carriageway_m, double width_m) {
  const roadquery::Edges edges = road.junction < 0
                                     ? carriageway_edges(road, foot.s)
                                     : roadquery::Edges{foot.t + 0.5 * carriageway_m, foot.t - 0.5 * carriageway_m};
  const double across_m = edges.left_t - edges.right_t;
  return {.s = foot.s,
          .t = 0.5 * (edges.left_t + edges.right_t),
          .width = width_m > 0.0 ? std::min(width_m, across_m) : across_m};
}

/// Where a node of a path lies on a road, else on a connecting road. Roads end before junctions, and dead ends before
/// other roads: then the nearest place of the way that has a road, within a few metres.
std::optional<RoadFoot> foot_of_node(const LineFinder& finder, const RoadPath& path, std::size_t node) {
  constexpr double reach_m = 6.0;
  for (const bool on_road : {true, false}) {
    const auto accept = [&](const Road& road) {
      return road.layer == path.layer && !road.sections.empty() && (road.junction < 0) == on_road;
    };
    for (std::size_t step = 0; step < path.nodes.size(); ++step) {
      bool near = false;
      for (const bool before : {false, true}) {
        if (before ? step > node : node + step >= path.nodes.size()) continue;
        const std::size_t at = before ? node - step : node + step;
        if (distance(path.nodes[at].p, path.nodes[node].p) > reach_m) continue;
        near = true;
        if (auto foot = finder.find(path.nodes[at].p, direction_at(path, at), accept)) return foot;
      }
      if (!near) break;
    }
  }
  return std::nullopt;
}

}  // namespace

void add_hump_objects(std::span<const RaisedHump> humps, RoadMap& map) {
  if (humps.empty()) return;
  const LineFinder finder(map);
  for (const RaisedHump& hump : humps) {
    const auto foot = finder.find(hump.p, hump.direction,
                                  [](const Road& road) { return road.junction < 0 && !road.sections.empty(); });
    if (!foot) continue;
    Road& road = map.roads[foot->road];
    roadquery::RoadObject object = object_across(road, *foot, 0.0, 0.0);
    object.type = hump_object, object.subtype = hump_subtype, object.name = hump.value;
    object.length = hump.length_m;
    road.objects.push_back(std::move(object));
  }
}

void add_barriers(const NetworkPlan& plan, RoadMap& map, Findings& findings) {
  std::map<std::int64_t, NodeSign> barriers;
  for (const NodeSign& sign : plan.roads.signs)
    if (sign.kind == NodeSignKind::barrier) barriers.emplace(sign.osm_node, sign);
  if (barriers.empty()) return;
  const LineFinder finder(map);
  for (const RoadPath& path : plan.roads.paths)
    for (std::size_t i = 0; i < path.nodes.size(); ++i) {
      const RoadNode& node = path.nodes[i];
      const auto found = barriers.find(node.osm_node);
      if (!is_osm_node(node.osm_node) || found == barriers.end()) continue;
      const NodeSign sign = found->second;
      barriers.erase(found);
      const RoadBarrier& barrier = road_barrier(sign.value);
      const auto foot = foot_of_node(finder, path, i);
      const auto tell = [&](Severity severity, const char* code, const char* what) {
        findings.push_back(
            {severity, code,
             fmt::format("way {}: barrier={} (node {}) {}", path.osm_id, sign.value, sign.osm_node, what), node.p.x,
             node.p.y});
      };
      if (sign.closed)
        tell(Severity::warning, "network.barrier_in_the_way",
             "closes the road to cars, but its lanes lead on through it; no car should drive there");
      if (!foot) {
        tell(Severity::info, "network.barrier_left_out", "lies where no road runs straight under it, it has no object");
        continue;
      }
      Road& road = map.roads[foot->road];
      roadquery::RoadObject object = object_across(road, *foot, node.width_m, barrier.width_m);
      object.type = barrier.object, object.subtype = sign.value,
      object.name = sign.closed ? "closed to cars" : sign.value;
      object.length = barrier.length_m, object.height = barrier.height_m;
      road.objects.push_back(std::move(object));
    }
}

}  // namespace orthodrive::network
