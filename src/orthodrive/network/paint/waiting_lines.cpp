// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/waiting_lines.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/network/paint/crosswalks.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Edges;
using roadquery::Lane;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double sign_reach_m = 40.0;       // along the way, from the node where the roads meet
constexpr double far_end_m = 30.0;          // a road that ends further from there is the prong of a narrow fork
constexpr double before_end_m = 0.75;       // middle of the line
constexpr double crosswalk_reach_m = 12.0;  // of a crosswalk that belongs to the junction
constexpr double before_crosswalk_m = 1.0;  // RMS-1 1993: the stop line lies 1 m before the crossing
constexpr double merge_rad = 0.5;

/// Signs on nodes, and which nodes are junctions.
class Signs {
 public:
  explicit Signs(const NetworkPlan& plan) : plan_(plan) {
    for (const NodeSign& sign : plan.roads.signs)
      if (sign.kind <= NodeSignKind::traffic_signals)
        at_node_[sign.osm_node].push_back(sign);
      else if (sign.kind == NodeSignKind::mini_roundabout)
        mini_roundabouts_.insert(sign.osm_node);
    for (const VertexIndex v : plan.topology.vertices.indices())
      if (plan.junctions.junction_of_vertex[v] >= 0) junctions_.insert(plan.topology.vertices[v].osm_node);
  }

  /// The sign for who drives on a path to a vertex, along the path or against it; nullptr for none.
  [[nodiscard]] const NodeSign* find(const RoadPath& path, std::int64_t vertex, bool along) const {
    if (at_node_.empty() || vertex == 0) return nullptr;
    if (const NodeSign* here = lights_at(vertex)) return here;
    const auto node_at = std::ranges::find(path.nodes, vertex, &RoadNode::osm_node);
    if (node_at == path.nodes.end()) return nullptr;
    const auto count = static_cast<std::ptrdiff_t>(path.nodes.size()), at = node_at - path.nodes.begin();
    const std::ptrdiff_t step = along ? -1 : 1;
    const NodeSign* found = nullptr;
    double found_m = 0.0;
    for (std::ptrdiff_t i = at + step; i >= 0 && i < count; i += step) {
      const RoadNode& node = path.nodes[static_cast<std::size_t>(i)];
      const double away_m = std::abs(node.s_m - node_at->s_m);
      // A sign without a direction is the nearer junction's.
      if (found && found->direction == 0 && is_osm_node(node.osm_node) && junctions_.contains(node.osm_node))
        return away_m - found_m < found_m ? nullptr : found;
      if (is_osm_node(node.osm_node) && junctions_.contains(node.osm_node)) break;
      if (found ? found->direction != 0 || away_m > 2.0 * found_m : away_m > sign_reach_m) break;
      const auto signs = at_node_.find(node.osm_node);
      if (found || !is_osm_node(node.osm_node) || signs == at_node_.end()) continue;
      for (const NodeSign& sign : signs->second)
        if (sign.direction == 0 || (sign.direction > 0) == along) found = &sign, found_m = away_m;
    }
    return found;
  }

  /// A mini-roundabout that had no room for its ring: all give way.
  [[nodiscard]] bool is_mini_roundabout(std::int64_t vertex) const { return mini_roundabouts_.contains(vertex); }

 private:
  [[nodiscard]] const NodeSign* lights_at(std::int64_t node) const {
    const auto signs = at_node_.find(node);
    if (signs == at_node_.end()) return nullptr;
    const auto lights = std::ranges::find(signs->second, NodeSignKind::traffic_signals, &NodeSign::kind);
    return lights == signs->second.end() ? nullptr : &*lights;
  }

  const NetworkPlan& plan_;
  std::map<std::int64_t, std::vector<NodeSign>> at_node_;
  std::set<std::int64_t> junctions_, mini_roundabouts_;
};

double heading_into(const Road& road, bool at_end) {
  const double hdg = roadquery::reference_point(road, at_end ? road.length : 0.0).hdg;
  return at_end ? hdg : hdg + M_PI;
}

/// Whether a slip road runs into a road of the highest class almost along it.
bool merges(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends, const JunctionEnd& end, int highest,
            const RoadMap& map) {
  const Road& road = map.roads[static_cast<std::size_t>(end.road)];
  if (!is_link_class(road.highway)) return false;
  const double heading = heading_into(road, end.at_end);
  return std::ranges::any_of(ends, [&](const JunctionEnd& other) {
    const double out = heading_into(map.roads[static_cast<std::size_t>(other.road)], other.at_end) + M_PI;
    return &other != &end && rank_of(plan, other) == highest && std::cos(out - heading) > std::cos(merge_rad);
  });
}

bool is_paved(const Road& road) {
  const SurfaceClass surface = surface_of(road);
  return surface == SurfaceClass::asphalt || surface == SurfaceClass::concrete || surface == SurfaceClass::setts;
}

bool must_give_way(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends, const JunctionEnd& end, int highest,
                   const RoadMap& map) {
  const int rank = rank_of(plan, end);
  const Road& road = map.roads[static_cast<std::size_t>(end.road)];
  if (rank >= highest || highest < road_rank("tertiary") || rank <= road_rank("service") || road.highway == "track" ||
      !is_paved(road))
    return false;
  return !merges(plan, ends, end, highest, map);
}

/// s of the line's middle; before a crosswalk near the end.
double place_of_line(const Road& road, bool at_end) {
  double before_m = before_end_m;
  for (const roadquery::RoadObject& object : road.objects) {
    if (object.type != "crosswalk") continue;
    const double from_end_m = at_end ? road.length - object.s : object.s;
    const double far_side_m = from_end_m + 0.5 * crosswalk_m;
    if (far_side_m - crosswalk_m <= crosswalk_reach_m)
      before_m = std::max(before_m, far_side_m + before_crosswalk_m + 0.5 * waiting_line_m);
  }
  return at_end ? road.length - before_m : before_m;
}

void add_line(Road& road, bool at_end, const char* name) {
  const double s = place_of_line(road, at_end), half = 0.5 * waiting_line_m;
  if (s < half || s > road.length - half) return;
  const Edges edges = incoming_edges(road, at_end, s);
  if (edges.left_t - edges.right_t < 1.0) return;
  road.objects.push_back({.type = "roadMark",
                          .subtype = "signalLines",
                          .name = name,
                          .s = s,
                          .t = 0.5 * (edges.left_t + edges.right_t),
                          .length = waiting_line_m,
                          .width = edges.left_t - edges.right_t});
  road.objects.back().outline = {
      {s - half, edges.right_t}, {s + half, edges.right_t}, {s + half, edges.left_t}, {s - half, edges.left_t}};
}

}  // namespace

int rank_of(const NetworkPlan& plan, const JunctionEnd& end) {
  const Stretch& stretch = plan.junctions.stretches[end.stretch];
  const std::size_t k = piece_at(plan.geometry[stretch.chain], end.chain_s);
  const PieceIndex piece = plan.topology.chains[stretch.chain].pieces[k].piece;
  return plan.topology.ring_of_piece[piece] >= 0 ? ring_rank : road_rank(plan.roads.paths[end.path].highway);
}

Edges incoming_edges(const Road& road, bool at_end, double s) {
  const bool right = at_end != (road.driving_side == roadquery::DrivingSide::left);
  const roadquery::LaneSection& section = roadquery::section_at(road, s);
  const double middle = roadquery::evaluate(road.lane_offset, s);
  double outer = middle;
  const auto add = [&](const std::vector<Lane>& lanes, double side) {
    for (const Lane& lane : lanes)
      if (roadquery::is_driven(lane.type)) outer += side * roadquery::lane_width(lane, s - section.s);
  };
  add(right ? section.right : section.left, right ? -1.0 : 1.0);
  if (outer == middle) add(right ? section.left : section.right, right ? 1.0 : -1.0);  // one lane for both directions
  return {std::max(middle, outer), std::min(middle, outer)};
}

void add_waiting_lines(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends, RoadMap& map) {
  const Signs signs(plan);
  for (const std::vector<JunctionEnd>& junction : ends) {
    int highest = -1;
    for (const JunctionEnd& end : junction) highest = std::max(highest, rank_of(plan, end));
    const bool all_give_way = std::ranges::any_of(junction, [&](const JunctionEnd& end) {
      return signs.is_mini_roundabout(plan.topology.vertices[end.vertex].osm_node);
    });
    for (const JunctionEnd& end : junction) {
      Road& road = map.roads[static_cast<std::size_t>(end.road)];
      const roadquery::RoadLink& link = end.at_end ? road.successor : road.predecessor;
      if (link.kind != roadquery::LinkKind::junction || lanes_of_direction(road, end.at_end).empty()) continue;
      const Vertex& vertex = plan.topology.vertices[end.vertex];
      const auto tip = roadquery::reference_point(road, end.at_end ? road.length : 0.0);
      if (distance(vertex.p, {tip.x, tip.y}) > far_end_m) continue;
      const NodeSign* sign = signs.find(plan.roads.paths[end.path], vertex.osm_node, end.at_end);
      if (sign)
        add_line(road, end.at_end, sign->kind == NodeSignKind::give_way ? give_way_line : stop_line);
      else if (all_give_way || must_give_way(plan, junction, end, highest, map))
        add_line(road, end.at_end, give_way_line);
    }
  }
}

}  // namespace orthodrive::network
