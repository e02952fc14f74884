#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "orthodrive/network/crown_shape.hpp"
#include "orthodrive/network/lanes.hpp"
#include "orthodrive/network/road_parts.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ContactPoint;
using roadquery::Cubic;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

// Sharper than this is turning round: between the prongs of a fork. Allowed only where there is no other way on.
constexpr double max_turn_rad = 150.0 * std::numbers::pi / 180.0;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A road end as a driver passes it, in driving direction.
struct Gate {
  Pose pose;
  double z_m = 0.0, gradient = 0.0, banking = 0.0, banking_rate = 0.0, crown = 0.0;  ///< crown: its tangent
  double lane_width_m = 0.0;
  double inner_t_m = 0.0;  ///< of the edge between the lanes of this direction and the oncoming ones
  std::vector<int> lanes;  ///< of this direction, from the inside out
};

Gate gate_of(const Road& road, bool at_end, bool incoming) {
  const bool along_s = at_end == incoming;
  const double s = at_end ? road.length : 0.0, sign = along_s ? 1.0 : -1.0;
  const roadquery::PlanPoint q = roadquery::reference_point(road, s);
  Gate gate;
  gate.pose = {{q.x, q.y}, Vec2{std::cos(q.hdg), std::sin(q.hdg)} * sign};
  gate.z_m = roadquery::elevation(road, s);
  gate.gradient = sign * roadquery::gradient(road, s);
  gate.banking = sign * roadquery::superelevation(road, s);
  gate.banking_rate = roadquery::derivative(road.superelevation, s);  // both the value and s change sign
  gate.crown = -roadquery::shape(road, s, 1.0).h;
  const roadquery::LaneSection& section = road.sections.front();
  gate.lane_width_m = roadquery::lane_width(section.right.empty() ? section.left.front() : section.right.front(), s);
  gate.inner_t_m = sign * roadquery::evaluate(road.lane_offset, s);
  gate.lanes = lanes_of_direction(road, along_s);
  return gate;
}

double turn_between(const Gate& in, const Gate& out) {
  return std::atan2(cross(in.pose.direction, out.pose.direction), dot(in.pose.direction, out.pose.direction));
}

/// Vertices of a joined junction that can be driven to from `from` on its inner pieces of way.
std::set<int> reachable_vertices(const NetworkPlan& plan, const std::vector<std::vector<int>>& inside, int junction, int from) {
  std::set<int> reached{from};
  for (bool grown = true; grown;) {
    grown = false;
    for (const int i : inside[at(junction)]) {
      const Stretch& stretch = plan.junctions.stretches[at(i)];
      const Chain& chain = plan.topology.chains[at(stretch.chain)];
      const ChainGeometry& geometry = plan.geometry[at(stretch.chain)];
      bool forward = true, backward = true;
      for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
        if (geometry.vertex_s[k] < stretch.s0 || geometry.vertex_s[k + 1] > stretch.s1) continue;
        const ChainPiece part = chain.pieces[k];
        if (plan.roads.paths[at(plan.topology.pieces[at(part.piece)].path)].oneway == Oneway::no) continue;
        (part.reversed ? forward : backward) = false;
      }
      if (forward && reached.count(stretch.vertex0)) grown |= reached.insert(stretch.vertex1).second;
      if (backward && reached.count(stretch.vertex1)) grown |= reached.insert(stretch.vertex0).second;
    }
  }
  return reached;
}

/// A way from one end to another, by lanes counted from the inside (0 = innermost).
struct Movement {
  int from = 0, to = 0;  ///< indices of ends
  double turn_rad = 0.0;
  std::size_t first_in = 0, count_in = 0, first_out = 0, count_out = 0;
};

/// The straightest way on (the chain's own one if there is one) takes all lanes; lanes that the other side lacks taper
/// out. Other turns take the lane next to where they go.
std::vector<Movement> choose_movements(const std::vector<JunctionEnd>& ends, const std::vector<Gate>& in,
                                       const std::vector<Gate>& out, std::size_t from, const std::set<int>& reached,
                                       bool left_hand_traffic) {
  std::vector<Movement> movements;
  for (std::size_t to = 0; to < ends.size(); ++to) {
    if (out[to].lanes.empty() || reached.count(ends[to].vertex) == 0) continue;
    // Back into the same road: only round a circuit, not round a block's inner drive.
    if (ends[to].road == ends[from].road && static_cast<int>(to) != ends[from].through) continue;
    movements.push_back({static_cast<int>(from), static_cast<int>(to), turn_between(in[from], out[to])});
  }
  if (movements.empty() || in[from].lanes.empty()) return {};
  const auto bend = [&](const Movement& m) { return m.to == ends[from].through ? -1.0 : std::abs(m.turn_rad); };
  const Movement main = *std::min_element(movements.begin(), movements.end(),
                                          [&](const Movement& a, const Movement& b) { return bend(a) < bend(b); });
  std::erase_if(movements, [&](const Movement& m) { return m.to != main.to && std::abs(m.turn_rad) > max_turn_rad; });
  for (Movement& m : movements) {
    const std::size_t lanes_in = in[from].lanes.size(), lanes_out = out[at(m.to)].lanes.size();
    if (m.to == main.to) {
      m.count_in = lanes_in, m.count_out = lanes_out;
      continue;
    }
    const bool inwards = (m.turn_rad > 0.0) != left_hand_traffic;
    m.first_in = inwards ? 0 : lanes_in - 1, m.first_out = inwards ? 0 : lanes_out - 1;
    m.count_in = m.count_out = 1;
  }
  return movements;
}

struct Geometry {
  std::vector<roadquery::PlanElement> plan;
  std::vector<Cubic> elevation, superelevation, crown;
};

/// Cut from the chain that runs through the junction.
Geometry chain_through(const NetworkPlan& plan, const JunctionEnd& from, const JunctionEnd& to) {
  const Stretch& stretch = plan.junctions.stretches[at(from.stretch)];
  const ChainGeometry& chain = plan.geometry[at(stretch.chain)];
  // Against the chain when `from` lies at the beginning of its stretch.
  const bool reversed = from.chain_s == stretch.s0 + stretch.trim0_m;
  double s0 = reversed ? to.chain_s : from.chain_s, s1 = reversed ? from.chain_s : to.chain_s;
  if (s1 <= s0) s1 += chain.length_m;  // a closed chain's first stretch follows its last one
  Geometry result{slice_plan(chain.plan, s0, s1), slice_profile(chain.elevation, s0, s1),
                  slice_profile(chain.superelevation, s0, s1), slice_profile(chain.crown, s0, s1)};
  if (!reversed) return result;
  const double length = plan_length(result.plan);
  return {reverse_plan(result.plan), reverse_profile(result.elevation, length),
          reverse_profile(result.superelevation, length, -1.0), reverse_profile(result.crown, length)};
}

Geometry turning(const Gate& in, const Gate& out) {
  Geometry result;
  // Differences of UTM coordinates lose digits: work relative to the start.
  result.plan = turn({{}, in.pose.direction}, {out.pose.p - in.pose.p, out.pose.direction});
  for (roadquery::PlanElement& e : result.plan) e.x += in.pose.p.x, e.y += in.pose.p.y;
  const double length = plan_length(result.plan);
  result.elevation = {hermite(0.0, length, in.z_m, out.z_m, in.gradient, out.gradient)};
  if (in.banking != 0.0 || out.banking != 0.0 || in.banking_rate != 0.0 || out.banking_rate != 0.0)
    result.superelevation = {hermite(0.0, length, in.banking, out.banking, in.banking_rate, out.banking_rate)};
  if (in.crown != 0.0 || out.crown != 0.0) result.crown = {hermite(0.0, length, in.crown, out.crown, 0.0, 0.0)};
  return result;
}

void add_connecting_lanes(Road& road, const Movement& m, const Gate& in, const Gate& out) {
  const double side = road.left_hand_traffic ? 1.0 : -1.0;
  const auto inner_t = [side](const Gate& gate, std::size_t first) {
    return gate.inner_t_m + side * static_cast<double>(first) * gate.lane_width_m;
  };
  const double t0 = inner_t(in, m.first_in), t1 = inner_t(out, m.first_out);
  if (t0 != 0.0 || t1 != 0.0) road.lane_offset = {hermite(0.0, road.length, t0, t1, 0.0, 0.0)};
  roadquery::LaneSection section;
  section.center.type = roadquery::LaneType::none;
  section.center.marks.push_back({0.0, "none", 0.0});
  for (std::size_t i = 0; i < std::max(m.count_in, m.count_out); ++i) {
    roadquery::Lane lane;
    lane.id = static_cast<int>(side) * (static_cast<int>(i) + 1);
    const double w0 = i < m.count_in ? in.lane_width_m : 0.0, w1 = i < m.count_out ? out.lane_width_m : 0.0;
    lane.width = {hermite(0.0, road.length, w0, w1, 0.0, 0.0)};
    if (i < m.count_in) lane.predecessor = in.lanes[m.first_in + i];
    if (i < m.count_out) lane.successor = out.lanes[m.first_out + i];
    lane.marks.push_back({0.0, "none", 0.0});
    (road.left_hand_traffic ? section.left : section.right).push_back(std::move(lane));
  }
  road.sections.push_back(std::move(section));
}

Road connecting_road(const NetworkPlan& plan, const RoadMap& map, const std::vector<JunctionEnd>& ends, const Movement& m,
                     const Gate& in, const Gate& out) {
  const JunctionEnd &from = ends[at(m.from)], &to = ends[at(m.to)];
  const Road &incoming = map.roads[at(from.road)], &outgoing = map.roads[at(to.road)];
  Road road;
  road.left_hand_traffic = plan.options.left_hand_traffic;
  road.highway = road_rank(incoming.highway) <= road_rank(outgoing.highway) ? incoming.highway : outgoing.highway;
  road.layer = incoming.layer;
  road.bridge = incoming.bridge && outgoing.bridge;
  road.tunnel = incoming.tunnel && outgoing.tunnel;
  if (incoming.osm_id == outgoing.osm_id) road.osm_id = incoming.osm_id;
  Geometry geometry = m.to == from.through ? chain_through(plan, from, to) : turning(in, out);
  road.plan = std::move(geometry.plan);
  road.elevation = std::move(geometry.elevation);
  road.superelevation = std::move(geometry.superelevation);
  road.length = plan_length(road.plan);
  road.shape = crown_shape(geometry.crown, road.length);
  road.predecessor = {LinkKind::road, incoming.id, from.at_end ? ContactPoint::end : ContactPoint::start};
  road.successor = {LinkKind::road, outgoing.id, to.at_end ? ContactPoint::end : ContactPoint::start};
  add_connecting_lanes(road, m, in, out);
  return road;
}

}  // namespace

void add_junctions(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends, RoadMap& map) {
  std::vector<std::vector<int>> inside(ends.size());
  for (std::size_t i = 0; i < plan.junctions.stretches.size(); ++i) {
    const Stretch& stretch = plan.junctions.stretches[i];
    if (stretch.inside) inside[at(plan.junctions.junction_of_vertex[at(stretch.vertex0)])].push_back(static_cast<int>(i));
  }
  for (std::size_t j = 0; j < ends.size(); ++j) {
    std::vector<Gate> in, out;
    for (const JunctionEnd& end : ends[j]) {
      in.push_back(gate_of(map.roads[at(end.road)], end.at_end, true));
      out.push_back(gate_of(map.roads[at(end.road)], end.at_end, false));
    }
    roadquery::Junction junction{.id = static_cast<int>(j) + 1};
    for (std::size_t from = 0; from < ends[j].size(); ++from) {
      const std::set<int> reached = reachable_vertices(plan, inside, static_cast<int>(j), ends[j][from].vertex);
      for (const Movement& m : choose_movements(ends[j], in, out, from, reached, plan.options.left_hand_traffic)) {
        Road road = connecting_road(plan, map, ends[j], m, in[at(m.from)], out[at(m.to)]);
        road.id = static_cast<int>(map.roads.size()) + 1;
        road.junction = junction.id;
        roadquery::Connection connection{static_cast<int>(junction.connections.size()), road.predecessor.id, road.id,
                                         ContactPoint::start};
        const roadquery::LaneSection& section = road.sections.front();
        for (const roadquery::Lane& lane : road.left_hand_traffic ? section.left : section.right)
          if (lane.predecessor) connection.lane_links.push_back({*lane.predecessor, lane.id});
        junction.connections.push_back(std::move(connection));
        map.roads.push_back(std::move(road));
      }
    }
    if (junction.connections.empty()) continue;
    for (const JunctionEnd& end : ends[j]) {
      Road& road = map.roads[at(end.road)];
      (end.at_end ? road.successor : road.predecessor) = {LinkKind::junction, junction.id};
    }
    map.junctions.push_back(std::move(junction));
  }
}

}  // namespace orthodrive::network
