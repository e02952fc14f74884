// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "orthodrive/core/median.hpp"
#include "orthodrive/network/roads/gates.hpp"
#include "orthodrive/network/roads/inner_ways.hpp"
#include "orthodrive/network/roads/movement_roads.hpp"
#include "orthodrive/network/roads/movements.hpp"
#include "orthodrive/network/roads/road_parts.hpp"
#include "orthodrive/network/roads/turn_rules.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

/// Who comes from a road of the highest class goes before who comes from others; the ring of a roundabout before all.
/// `roads` are the connecting roads of the movements (1.7, 12.7: priorities are between those).
std::vector<roadquery::Priority> priorities_of(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends,
                                               const std::vector<Movement>& movements, const std::vector<int>& roads) {
  const auto rank = [&](const Movement& m) {
    const JunctionEnd& end = ends[as_index(m.from)];
    const Stretch& stretch = plan.junctions.stretches[end.stretch];
    const std::size_t k = piece_at(plan.geometry[stretch.chain], end.chain_s);
    const PieceIndex piece = plan.topology.chains[stretch.chain].pieces[k].piece;
    constexpr int ring_rank = 100;
    return plan.topology.ring_of_piece[piece] >= 0 ? ring_rank : road_rank(plan.roads.paths[end.path].highway);
  };
  int highest = -1;
  for (const Movement& m : movements) highest = std::max(highest, rank(m));
  std::vector<roadquery::Priority> priorities;
  for (std::size_t i = 0; i < movements.size(); ++i)
    for (std::size_t k = 0; k < movements.size(); ++k)
      if (rank(movements[i]) == highest && rank(movements[k]) < highest) priorities.push_back({roads[i], roads[k]});
  return priorities;
}

int level_of(const Road& road) { return road.layer != 0 ? road.layer : road.bridge ? 1 : road.tunnel ? -1 : 0; }

/// All of a junction lies on one level, for it has one surface. Where some of its roads lie on the ground, a bridge (or
/// tunnel) begins at the end of its own road, unless it goes on through the junction or much of it lies inside.
int level_of_junction(const NetworkPlan& plan, const RoadMap& map, const std::vector<JunctionEnd>& ends) {
  constexpr double most_inside_m = 10.0;
  const auto level_at = [&](const JunctionEnd& end) { return level_of(map.roads[as_index(end.road)]); };
  int level = 0;
  bool is_beside_ground = false, goes_on_inside = false;
  for (const JunctionEnd& end : ends) {
    const int own = level_at(end);
    if (std::abs(own) > std::abs(level)) level = own;
    if (own == 0) {
      is_beside_ground = true;
      continue;
    }
    const Stretch& stretch = plan.junctions.stretches[end.stretch];
    const double inside_m = end.at_begin ? end.chain_s - stretch.s0 : stretch.s1 - end.chain_s;
    const bool goes_through = end.through >= 0 && level_at(ends[as_index(end.through)]) != 0;
    goes_on_inside = goes_on_inside || goes_through || inside_m > most_inside_m;
  }
  return is_beside_ground && !goes_on_inside ? 0 : level;
}

/// CARLA takes the number of a junction for a road's if there is a road of that number.
void number_junctions_after_roads(RoadMap& map) {
  const int last_road = map.roads.empty() ? 0 : map.roads.back().id;
  for (Road& road : map.roads) {
    if (road.junction >= 0) road.junction += last_road;
    for (roadquery::RoadLink* link : {&road.predecessor, &road.successor})
      if (link->kind == LinkKind::junction) link->id += last_road;
  }
  for (roadquery::Junction& junction : map.junctions) junction.id += last_road;
}

/// Vertices of every junction.
std::vector<std::vector<VertexIndex>> vertices_of_junctions(const NetworkPlan& plan, std::size_t junctions) {
  std::vector<std::vector<VertexIndex>> vertices(junctions);
  for (const VertexIndex v : plan.topology.vertices.indices())
    if (const int j = plan.junctions.junction_of_vertex[v]; j >= 0) vertices[as_index(j)].push_back(v);
  return vertices;
}

/// The median of what was seen at the nodes of a junction; 0: nothing.
double seen_kerb_radius_m(const NetworkPlan& plan, const std::vector<VertexIndex>& vertices) {
  std::vector<double> radii;
  for (const VertexIndex v : vertices)
    for (const PieceEnd& end : plan.topology.vertices[v].ends) {
      const PathPiece& piece = plan.topology.pieces[end.piece];
      const RoadNode& node = plan.roads.paths[piece.path].nodes[end.at_last ? piece.last : piece.first];
      if (node.kerb_radius_m <= 0.0) continue;
      radii.push_back(node.kerb_radius_m);
      break;  // all ends of a vertex are one node
    }
  if (radii.empty()) return 0.0;
  return median(std::move(radii));
}

/// Of the junctions of which one was seen, by their final numbers.
std::map<int, double> seen_kerb_radii_m(const NetworkPlan& plan, const RoadMap& map, std::size_t junctions) {
  std::map<int, double> radii_m;
  const std::vector<std::vector<VertexIndex>> vertices = vertices_of_junctions(plan, junctions);
  for (const roadquery::Junction& junction : map.junctions) {
    const std::vector<VertexIndex>& here = vertices[as_index(junction.id - map.roads.back().id - 1)];
    if (const double radius = seen_kerb_radius_m(plan, here); radius > 0.0) radii_m[junction.id] = radius;
  }
  return radii_m;
}

}  // namespace

JunctionParts add_junctions(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends, RoadMap& map,
                            Findings& findings) {
  JunctionParts parts;
  const std::vector<std::vector<InnerWay>> inside = inner_ways(plan, ends.size());
  const TurnRules rules(settled_restrictions(plan.roads, plan.topology));
  std::set<std::size_t> followed;  // restrictions over ways inside a junction
  for (std::size_t j = 0; j < ends.size(); ++j) {
    std::vector<Gate> in, out;
    for (const JunctionEnd& end : ends[j]) {
      const RoadPath& path = plan.roads.paths[end.path];
      in.push_back(gate_of(map.roads[as_index(end.road)], path, end.at_end, true));
      out.push_back(gate_of(map.roads[as_index(end.road)], path, end.at_end, false));
    }
    const std::vector<Movement> movements = movements_of(plan, rules, inside[j], ends[j], in, out, followed, findings);
    roadquery::Junction junction{.id = static_cast<int>(j) + 1};
    std::vector<int> connecting;
    const int level = level_of_junction(plan, map, ends[j]);
    for (const Movement& m : movements) {
      Road road = connecting_road(plan, map, ends[j], m, level, in[as_index(m.from)], out[as_index(m.to)]);
      road.id = static_cast<int>(map.roads.size()) + 1;
      road.junction = junction.id;
      roadquery::Connection connection{static_cast<int>(junction.connections.size()), road.predecessor.id, road.id,
                                       ContactPoint::start};
      const roadquery::LaneSection& section = road.sections.front();
      for (const roadquery::Lane& lane : road.driving_side == DrivingSide::left ? section.left : section.right)
        if (lane.predecessor) connection.lane_links.push_back({*lane.predecessor, lane.id});
      junction.connections.push_back(std::move(connection));
      connecting.push_back(road.id);
      if (m.to == ends[j][as_index(m.from)].through) parts.straight.push_back(road.id);
      map.roads.push_back(std::move(road));
    }
    junction.priorities = priorities_of(plan, ends[j], movements, connecting);
    if (junction.connections.empty()) continue;
    for (const JunctionEnd& end : ends[j]) {
      Road& road = map.roads[as_index(end.road)];
      (end.at_end ? road.successor : road.predecessor) = {LinkKind::junction, junction.id};
    }
    map.junctions.push_back(std::move(junction));
  }
  report_restrictions_over_roads(plan, rules, followed, findings);
  number_junctions_after_roads(map);
  parts.kerb_radius_m = seen_kerb_radii_m(plan, map, ends.size());
  return parts;
}

}  // namespace orthodrive::network
