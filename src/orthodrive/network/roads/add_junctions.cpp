// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "orthodrive/core/median.hpp"
#include "orthodrive/network/curves/crown_shape.hpp"
#include "orthodrive/network/curves/ease_along.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"
#include "orthodrive/network/junctions/refit_profile.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "orthodrive/network/line/connecting_line.hpp"
#include "orthodrive/network/roads/road_parts.hpp"
#include "orthodrive/network/roads/turn_rules.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ContactPoint;
using roadquery::Cubic;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

// Sharper than this is turning round: between the prongs of a fork, or into a road that leads back to the junction that
// one comes from. Allowed only where there is no other way on.
constexpr double max_turn_rad = 150.0 * std::numbers::pi / 180.0, max_turn_back_rad = 140.0 * std::numbers::pi / 180.0;

// What a driver still calls straight on when arrows are read.
constexpr double straight_turn_rad = 35.0 * std::numbers::pi / 180.0;

// Jumps of the gradient on connecting roads that turn, driven at walking pace: 1 % 2 m off the reference line. At 4 m/s
// a wheel gets 0.04 m/s from it, as from 0.1 % at 40 m/s.
constexpr double max_crown_rate_jump_in_turns = 5e-3;  // 1/m

constexpr double inner_look_m = 8.0;  // over which an inner way of a joined junction has its direction

constexpr double shortest_turn_m = 0.5;  // of a reference line that is moved to the inside of its bend

std::size_t as_index(int i) { return static_cast<std::size_t>(i); }

/// A road end as a driver passes it, in driving direction.
struct Gate {
  Pose pose;
  double z_m = 0.0, gradient = 0.0, banking = 0.0, banking_rate = 0.0, crown = 0.0;  ///< crown: its tangent
  double outer_rest_m = 0.0, inner_rest_m = 0.0;  ///< widths of what lies beside the lanes of one direction alone
  double inner_t_m = 0.0;  ///< of the edge between the lanes of this direction and the oncoming ones
  std::vector<int> lanes;  ///< of this direction, from the inside out
  std::vector<double> lane_widths_m, lanes_from_m;  ///< of those lanes; their inner edges from inner_t_m outwards
  roadquery::LaneType type = roadquery::LaneType::driving;  ///< of those lanes, where they are none for cars
  std::vector<unsigned> arrows;  ///< of the lanes, where they are painted and the gate leads into the junction
};

/// Lanes of vehicles, without cycle lanes at the side.
bool is_lane(const roadquery::Lane& lane) {
  using roadquery::LaneType;
  return roadquery::is_driven(lane.type) || lane.type == LaneType::bus || lane.type == LaneType::taxi ||
         lane.type == LaneType::other;
}

/// Of the shoulder, strip or cycle lane of a side.
double rest_m(const std::vector<roadquery::Lane>& side, double s) {
  double width_m = 0.0;
  for (const roadquery::Lane& lane : side)
    if (is_rest(lane.type) || (lane.type == roadquery::LaneType::biking && &lane != side.data()))
      width_m += roadquery::lane_width(lane, s);
  return width_m;
}

/// How far the inner edge of a lane lies from that of its side's innermost one.
double inner_edge_m(const std::vector<roadquery::Lane>& side, std::size_t lane, double s) {
  double edge_m = 0.0;
  for (std::size_t i = 0; i < lane; ++i) edge_m += roadquery::lane_width(side[i], s);
  return edge_m;
}

/// Where the lanes of a gate's direction lie. `own`: the lanes on the side of that direction.
void place_lanes(const Road& road, const std::vector<roadquery::Lane>& own, const std::vector<roadquery::Lane>& others,
                 bool along_s, double s, Gate& gate) {
  const double side = road.driving_side == DrivingSide::left ? 1.0 : -1.0;
  gate.inner_t_m = (along_s ? 1.0 : -1.0) * roadquery::evaluate(road.lane_offset, s);
  gate.lanes = lanes_of_direction(road, along_s);
  if (gate.lanes.empty()) return;
  const auto index_in_side = [](int id) { return as_index(std::abs(id) - 1); };
  const bool is_own = std::ranges::find(own, gate.lanes.front(), &roadquery::Lane::id) != own.end();
  const std::vector<roadquery::Lane>& lanes = is_own ? own : others;
  const std::size_t first = index_in_side(gate.lanes.front());
  for (const int id : gate.lanes) {
    gate.lane_widths_m.push_back(roadquery::lane_width(lanes[index_in_side(id)], s));
    gate.lanes_from_m.push_back(is_own ? inner_edge_m(lanes, index_in_side(id), s) - inner_edge_m(lanes, first, s)
                                       : inner_edge_m(lanes, first, s) - inner_edge_m(lanes, index_in_side(id), s));
  }
  // Who drives against a road of lanes for both has their outer edge inside.
  gate.inner_t_m += side * (is_own ? inner_edge_m(lanes, first, s) : -inner_edge_m(lanes, first + 1, s));
  const roadquery::LaneType type = lanes[first].type;
  if (is_own && !roadquery::is_driven(type)) gate.type = type;
}

Gate gate_of(const Road& road, const RoadPath& path, bool at_end, bool incoming) {
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
  const bool right = along_s != (road.driving_side == DrivingSide::left);
  const auto &own = right ? section.right : section.left, &opposite = right ? section.left : section.right;
  gate.outer_rest_m = rest_m(own, s);
  if (std::ranges::none_of(opposite, is_lane) || std::ranges::none_of(own, is_lane))
    gate.inner_rest_m = rest_m(opposite, s);
  place_lanes(road, own, opposite, along_s, s, gate);
  if (incoming) gate.arrows = turn_lanes(path, along_s, road.driving_side);
  if (gate.arrows.size() != gate.lanes.size()) gate.arrows.clear();
  return gate;
}

/// How far from inner_t_m a gate's lane begins, or one more beside its outermost one would.
double lane_from_m(const Gate& gate, std::size_t lane) {
  if (lane < gate.lanes_from_m.size()) return gate.lanes_from_m[lane];
  return gate.lanes_from_m.empty() ? 0.0 : gate.lanes_from_m.back() + gate.lane_widths_m.back();
}
double lane_width_m(const Gate& gate, std::size_t lane) {
  return lane < gate.lane_widths_m.size() ? gate.lane_widths_m[lane] : 0.0;
}

double angle_between(Vec2 in, Vec2 out) { return std::atan2(cross(in, out), dot(in, out)); }

/// A piece of way between two vertices of a joined junction.
struct InnerWay {
  VertexIndex vertex0, vertex1;
  Leg leg;                               ///< from vertex0 to vertex1
  std::vector<std::int64_t> ways;        ///< OSM's, from vertex0 to vertex1
  std::vector<std::int64_t> nodes;       ///< OSM's, between one way and the next
  bool forward = true, backward = true;  ///< whether one may drive from vertex0 to vertex1, and back
  Vec2 direction0, direction1;           ///< at either end, driving from vertex0 to vertex1
};
InnerWay inner_way(const NetworkPlan& plan, const Stretch& stretch) {
  const Chain& chain = plan.topology.chains[stretch.chain];
  const ChainGeometry& geometry = plan.geometry[stretch.chain];
  InnerWay inner{
      .vertex0 = stretch.vertex0, .vertex1 = stretch.vertex1, .leg = {stretch.chain, stretch.s0, stretch.s1}};
  const auto place = [&](double s) { return pose_at(geometry.plan, std::clamp(s, stretch.s0, stretch.s1)).p; };
  inner.direction0 = normalized(place(stretch.s0 + inner_look_m) - place(stretch.s0));
  inner.direction1 = normalized(place(stretch.s1) - place(stretch.s1 - inner_look_m));
  for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
    if (geometry.vertex_s[k] < stretch.s0 || geometry.vertex_s[k + 1] > stretch.s1) continue;
    const DirectedPiece part = chain.pieces[k];
    const RoadPath& path = plan.roads.paths[plan.topology.pieces[part.piece].path];
    if (!inner.ways.empty()) inner.nodes.push_back(plan.topology.vertices[start_vertex(plan.topology, part)].osm_node);
    inner.ways.push_back(path.osm_id);
    if (path.oneway != Oneway::no) (part.reversed ? inner.forward : inner.backward) = false;
  }
  return inner;
}

/// Of every junction.
std::vector<std::vector<InnerWay>> inner_ways(const NetworkPlan& plan, std::size_t junctions) {
  std::vector<std::vector<InnerWay>> ways(junctions);
  for (const Stretch& stretch : plan.junctions.stretches)
    if (stretch.inside && stretch.vertex0 && stretch.vertex1)
      ways[as_index(plan.junctions.junction_of_vertex[stretch.vertex0])].push_back(inner_way(plan, stretch));
  return ways;
}

/// A vertex of a joined junction, and how one has come there.
struct Arrival {
  VertexIndex vertex;
  DrivenWay driven;
  Vec2 direction;                ///< in which one drives
  const InnerWay* on = nullptr;  ///< null: by the road that one comes from
  bool turned = false;           ///< one had to turn round on the way
  std::vector<Leg> legs;         ///< the inner ways that one has come
};

bool turns_round(Vec2 in, Vec2 out) { return std::abs(angle_between(in, out)) > max_turn_rad; }

std::int64_t node_of(const NetworkPlan& plan, VertexIndex vertex) { return plan.topology.vertices[vertex].osm_node; }

/// Where one is after an inner way; none where that is forbidden.
std::optional<DrivenWay> driven_over(const TurnRules& rules, DrivenWay driven, std::int64_t node, const InnerWay& inner,
                                     bool forward) {
  const std::size_t count = inner.ways.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t way = inner.ways[forward ? i : count - 1 - i];
    if (i > 0) node = inner.nodes[forward ? i - 1 : count - 1 - i];
    if (rules.forbid(driven, node, way)) return std::nullopt;
    driven = rules.drive_on(driven, node, way);
  }
  return driven;
}

/// The ways from an end's vertex to its cut, as if they lay inside. Where the map tells no restriction it is the way at
/// the cut alone: those of crossings without a node then miss what lies before the cut (docs/network.md, Limits).
InnerWay way_to_cut(const NetworkPlan& plan, const TurnRules& rules, const JunctionEnd& end) {
  InnerWay inner;
  if (!rules.are_told()) {
    inner.ways.push_back(plan.roads.paths[end.path].osm_id);
    return inner;
  }
  const Stretch& stretch = plan.junctions.stretches[end.stretch];
  const Chain& chain = plan.topology.chains[stretch.chain];
  const ChainGeometry& geometry = plan.geometry[stretch.chain];
  const double s0 = end.at_begin ? stretch.s0 : end.chain_s, s1 = end.at_begin ? end.chain_s : stretch.s1;
  constexpr double touches_m = 1e-6;
  for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
    if (geometry.vertex_s[k] > s1 - touches_m || geometry.vertex_s[k + 1] < s0 + touches_m) continue;
    const DirectedPiece part = chain.pieces[k];
    if (!inner.ways.empty()) inner.nodes.push_back(node_of(plan, start_vertex(plan.topology, part)));
    inner.ways.push_back(plan.roads.paths[plan.topology.pieces[part.piece].path].osm_id);
  }
  if (inner.ways.empty()) inner.ways.push_back(plan.roads.paths[end.path].osm_id);
  if (end.at_begin) return inner;
  std::ranges::reverse(inner.ways), std::ranges::reverse(inner.nodes);
  return inner;
}

/// Where one is at the vertex when one comes from the road of an end.
std::optional<DrivenWay> driven_in(const TurnRules& rules, const InnerWay& to_cut) {
  return driven_over(rules, {to_cut.ways.back(), {}}, 0, to_cut, false);
}

/// Where one can drive to from a road's end on the inner ways of a joined junction. First what needs no turning round.
/// A vertex is reached once from each inner way and with each state of the restrictions: their number bounds it.
std::vector<Arrival> arrivals_from(const NetworkPlan& plan, const std::vector<InnerWay>& inside, const TurnRules& rules,
                                   Arrival start) {
  constexpr std::size_t most_arrivals = 4096;  // against maps whose restrictions are made to harm
  std::vector<Arrival> arrivals{std::move(start)};
  for (const bool round : {false, true})
    for (std::size_t next = 0; next < arrivals.size() && arrivals.size() < most_arrivals; ++next) {
      const Arrival here = arrivals[next];
      const auto drive = [&](bool forward, VertexIndex from, Vec2 into, Arrival there) {
        const InnerWay& inner = *there.on;
        if (!(forward ? inner.forward : inner.backward) || from != here.vertex || here.on == there.on) return;
        const std::optional<DrivenWay> driven =
            driven_over(rules, here.driven, node_of(plan, here.vertex), inner, forward);
        if (!driven) return;
        there.driven = *driven;
        there.turned = here.turned || turns_round(here.direction, into);
        const auto known = [&](const Arrival& a) {
          return a.vertex == there.vertex && a.on == there.on && a.driven == there.driven;
        };
        if (there.turned && !round) return;
        if (std::ranges::any_of(arrivals, known)) return;
        there.legs.insert(there.legs.begin(), here.legs.begin(), here.legs.end());
        arrivals.push_back(there);
      };
      for (const InnerWay& w : inside) {
        drive(true, w.vertex0, w.direction0, {w.vertex1, {}, w.direction1, &w, false, {w.leg}});
        drive(false, w.vertex1, w.direction1 * -1.0,
              {w.vertex0, {}, w.direction0 * -1.0, &w, false, {{w.leg.chain, w.leg.s1, w.leg.s0}}});
      }
    }
  return arrivals;
}

/// How one drives from one end to another, by lanes counted from the inside (0 = innermost).
struct Movement {
  int from = 0, to = 0;  ///< indices of ends
  double turn_rad = 0.0;
  std::size_t first_in = 0, count_in = 0, first_out = 0, count_out = 0;
  bool turned = false;    ///< only by turning round inside the junction
  std::vector<Leg> legs;  ///< inner ways between the vertices of both ends
};

/// The lanes that arrows give a turn: from the first to the last that shows it. `bits`: what the turn may be called.
bool take_arrow_lanes(const std::vector<unsigned>& arrows, unsigned bits, bool main, Movement& m) {
  const auto shows = [&](unsigned lane) { return (lane & bits) != 0 || (main && (lane & ~unsigned{turn_merge}) == 0); };
  const auto first = std::find_if(arrows.begin(), arrows.end(), shows);
  if (first == arrows.end()) return false;
  const auto last = std::find_if(arrows.rbegin(), arrows.rend(), shows).base();
  m.first_in = static_cast<std::size_t>(first - arrows.begin());
  m.count_in = static_cast<std::size_t>(last - first);
  return true;
}

/// Lanes of a way on. By the arrows where there are any; else the straightest way (`main`) takes all lanes, and others
/// the lane next to where they go, or as many as the main way lacks (`surplus`). Arrows are no prohibition: a turn that
/// none shows takes its lanes, too.
void choose_lanes(Movement& m, bool main, double main_turn_rad, std::size_t surplus, const Gate& in, const Gate& out,
                  DrivingSide driving_side) {
  const std::size_t lanes_in = in.lanes.size(), lanes_out = out.lanes.size();
  const bool left = m.turn_rad > 0.0;
  // An exit of a ring may bend inwards, too, but less than the ring does. Turning round is done inwards.
  const bool inwards = std::abs(m.turn_rad) > max_turn_rad ||
                       (m.turn_rad > (main ? 0.0 : main_turn_rad)) != (driving_side == DrivingSide::left);
  const bool straight = std::abs(m.turn_rad) < straight_turn_rad;
  const unsigned side = left ? turn_left : turn_right;
  const unsigned bits = main && straight ? unsigned{turn_through} : straight ? (side | turn_through) : side;
  if (!in.arrows.empty() && take_arrow_lanes(in.arrows, bits, main, m)) {
    m.count_out = std::min(m.count_in, lanes_out);
    // Lanes that turn outwards enter outside, all others inside.
    m.first_out = straight || inwards ? 0 : lanes_out - m.count_out;
    if (straight && m.count_out == m.count_in) m.first_out = std::min(m.first_in, lanes_out - m.count_out);
    return;
  }
  if (main) {
    m.count_in = lanes_in, m.count_out = std::min(lanes_in, lanes_out);
    return;
  }
  m.count_in = m.count_out = std::clamp<std::size_t>(surplus, 1, lanes_out);
  m.first_in = inwards ? 0 : lanes_in - m.count_in, m.first_out = inwards ? 0 : lanes_out - m.count_out;
}

/// Whether both roads lead to the same other junction.
bool leads_back(const JunctionPlan& junctions, const JunctionEnd& from, const JunctionEnd& to) {
  const auto far_junction = [&](const JunctionEnd& end) {
    const Stretch& stretch = junctions.stretches[end.stretch];
    const VertexIndex vertex = end.at_begin ? stretch.vertex1 : stretch.vertex0;
    return vertex ? junctions.junction_of_vertex[vertex] : -1;
  };
  return far_junction(from) >= 0 && far_junction(from) == far_junction(to);
}

/// Movements from one end, without their lanes; the first one is the main one: the chain's own, or the straightest.
/// `sharp` collects turns that turn round; they are used only where a road has no other way in. `followed`:
/// restrictions over ways that one has come over.
std::vector<Movement> movements_from(const NetworkPlan& plan, const TurnRules& rules,
                                     const std::vector<InnerWay>& inside, const std::vector<JunctionEnd>& ends,
                                     const std::vector<Gate>& in, const std::vector<Gate>& out, std::size_t from,
                                     std::vector<Movement>& sharp, std::set<std::size_t>& followed) {
  std::vector<Movement> movements;
  if (in[from].lanes.empty()) return movements;
  const std::optional<DrivenWay> driven = driven_in(rules, way_to_cut(plan, rules, ends[from]));
  if (!driven) return movements;
  const std::vector<Arrival> arrivals =
      arrivals_from(plan, inside, rules, {ends[from].vertex, *driven, in[from].pose.direction});
  for (const Arrival& arrival : arrivals)
    for (const FollowedRestriction& f : arrival.driven.followed)
      if (rules.is_complete(f)) followed.insert(f.restriction);
  for (std::size_t to = 0; to < ends.size(); ++to) {
    bool reached = false, turned = true;
    std::vector<Leg> legs;  // of the first that comes there without turning round
    const InnerWay way_out = way_to_cut(plan, rules, ends[to]);
    for (const Arrival& arrival : arrivals) {
      if (arrival.vertex != ends[to].vertex ||
          !driven_over(rules, arrival.driven, node_of(plan, arrival.vertex), way_out, true))
        continue;
      const bool round = arrival.turned || (arrival.on && turns_round(arrival.direction, out[to].pose.direction));
      if (!reached || (turned && !round)) legs = arrival.legs;
      reached = true;
      turned = turned && round;
    }
    if (out[to].lanes.empty() || !reached) continue;
    // Back into the same road: only round a circuit, not round a block's inner drive.
    if (ends[to].stretch == ends[from].stretch && static_cast<int>(to) != ends[from].through) continue;
    movements.push_back({.from = static_cast<int>(from),
                         .to = static_cast<int>(to),
                         .turn_rad = angle_between(in[from].pose.direction, out[to].pose.direction),
                         .turned = turned,
                         .legs = std::move(legs)});
  }
  if (movements.empty()) return movements;
  const auto bend = [&](const Movement& m) {
    return std::pair{m.turned, m.to == ends[from].through ? -1.0 : std::abs(m.turn_rad)};
  };
  const auto main = std::min_element(movements.begin(), movements.end(),
                                     [&](const Movement& a, const Movement& b) { return bend(a) < bend(b); });
  std::rotate(movements.begin(), main, main + 1);
  const int main_to = movements.front().to;
  const bool main_turned = movements.front().turned;
  const auto is_sharp = [&](const Movement& m) {
    const bool back = leads_back(plan.junctions, ends[from], ends[as_index(m.to)]);
    return m.to != main_to &&
           ((m.turned && !main_turned) || std::abs(m.turn_rad) > (back ? max_turn_back_rad : max_turn_rad));
  };
  std::copy_if(movements.begin(), movements.end(), std::back_inserter(sharp), is_sharp);
  std::erase_if(movements, is_sharp);
  return movements;
}

/// Of the sharp turns into a road that nothing else leads into, the widest.
std::vector<Movement> only_ways_in(const std::vector<Movement>& movements, const std::vector<Movement>& sharp,
                                   std::size_t ends) {
  std::vector<Movement> only;
  for (std::size_t to = 0; to < ends; ++to) {
    const auto leads_there = [to](const Movement& m) { return m.to == static_cast<int>(to); };
    if (std::any_of(movements.begin(), movements.end(), leads_there)) continue;
    const Movement* widest = nullptr;
    for (const Movement& m : sharp)
      if (leads_there(m) && (!widest || std::abs(m.turn_rad) < std::abs(widest->turn_rad))) widest = &m;
    if (widest) only.push_back(*widest);
  }
  return only;
}

/// Turns back that are left out: from there a driver comes to that road only after turning round elsewhere.
void report_left_out(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends, const std::vector<Gate>& in,
                     const std::vector<Movement>& movements, const std::vector<Movement>& sharp, Findings& findings) {
  constexpr double degrees = 180.0 / std::numbers::pi;
  for (const Movement& m : sharp) {
    const JunctionEnd &from = ends[as_index(m.from)], &to = ends[as_index(m.to)];
    const bool kept = std::ranges::any_of(
        movements, [&m](const Movement& other) { return other.from == m.from && other.to == m.to; });
    if (kept || m.turned || std::abs(m.turn_rad) > max_turn_rad) continue;
    findings.push_back({Severity::info, "network.turn_left_out",
                        fmt::format("no turn of {:.0f} degrees from way {} into way {}, which leads back",
                                    std::abs(m.turn_rad) * degrees, plan.roads.paths[from.path].osm_id,
                                    plan.roads.paths[to.path].osm_id),
                        in[as_index(m.from)].pose.p.x, in[as_index(m.from)].pose.p.y});
  }
}

/// Every lane out of the junction is fed: where more lanes lead out than any way in brings, the outermost lane (or
/// innermost, for what opens inside) of the straightest way in leads into the others, too.
void feed_all_lanes(const std::vector<JunctionEnd>& ends, const std::vector<Gate>& out,
                    std::vector<Movement>& movements) {
  const std::size_t own = movements.size();
  for (std::size_t to = 0; to < ends.size(); ++to) {
    std::vector<bool> fed(out[to].lanes.size(), false);
    const Movement* main = nullptr;
    const auto bend = [&](const Movement& m) {
      return ends[as_index(m.from)].through == m.to ? -1.0 : std::abs(m.turn_rad);
    };
    for (std::size_t i = 0; i < own; ++i) {
      const Movement& m = movements[i];
      if (m.to != static_cast<int>(to)) continue;
      for (std::size_t k = 0; k < std::min(m.count_in, m.count_out); ++k) fed[m.first_out + k] = true;
      if (!main || bend(m) < bend(*main)) main = &m;
    }
    if (!main) continue;
    const Movement best = *main;
    for (std::size_t lane = 0; lane < fed.size(); ++lane) {
      if (fed[lane]) continue;
      Movement m = best;
      m.first_in = lane < best.first_out ? best.first_in : best.first_in + best.count_in - 1;
      m.first_out = lane, m.count_in = m.count_out = 1;
      movements.push_back(m);
    }
  }
}

/// The middle of a gate's lane.
Vec2 middle_of(const Gate& gate, std::size_t lane, DrivingSide driving_side) {
  const double side = driving_side == DrivingSide::left ? 1.0 : -1.0;
  const double t = gate.inner_t_m + side * (lane_from_m(gate, lane) + 0.5 * lane_width_m(gate, lane));
  return gate.pose.p + left_normal(gate.pose.direction) * t;
}

/// Lanes turn round towards the oncoming traffic: not into a lane that lies on their other side, as where the map draws
/// carriageways nearer to each other than their lanes are wide.
void keep_lanes_that_have_room(const NetworkPlan& plan, const std::vector<JunctionEnd>& ends,
                               const std::vector<Gate>& in, const std::vector<Gate>& out,
                               std::vector<Movement>& movements, Findings& findings) {
  constexpr double back_rad = 175.0 * std::numbers::pi / 180.0;  // beyond, the side is that of the oncoming traffic
  const DrivingSide driving_side = plan.options.driving_side;
  const auto has_room = [&](const Movement& m, std::size_t lane) {
    const Gate &from = in[as_index(m.from)], &to = out[as_index(m.to)];
    const bool left = std::abs(m.turn_rad) > back_rad ? driving_side == DrivingSide::right : m.turn_rad > 0.0;
    const Vec2 inwards = left_normal(from.pose.direction) * (left ? 1.0 : -1.0);
    const Vec2 across =
        middle_of(to, m.first_out + lane, driving_side) - middle_of(from, m.first_in + lane, driving_side);
    return dot(across, inwards) > 0.0;
  };
  for (Movement& m : movements) {
    if (!m.legs.empty() || std::abs(m.turn_rad) <= max_turn_rad) continue;
    std::size_t first = 0, end = std::min(m.count_in, m.count_out);
    while (first < end && !has_room(m, first)) ++first;
    while (end > first && !has_room(m, end - 1)) --end;
    if (end - first == std::min(m.count_in, m.count_out)) continue;
    findings.push_back({Severity::warning, "network.no_room_to_turn",
                        fmt::format("{} of {} lanes turn round from way {} into way {}: the others lie across each "
                                    "other, as the carriageways are drawn",
                                    end - first, std::min(m.count_in, m.count_out),
                                    plan.roads.paths[ends[as_index(m.from)].path].osm_id,
                                    plan.roads.paths[ends[as_index(m.to)].path].osm_id),
                        in[as_index(m.from)].pose.p.x, in[as_index(m.from)].pose.p.y});
    m.first_in += first, m.first_out += first, m.count_in = m.count_out = end - first;
  }
  std::erase_if(movements, [](const Movement& m) { return m.count_in == 0; });
}

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

struct Geometry {
  std::vector<roadquery::PlanElement> plan;
  std::vector<Cubic> elevation, superelevation, crown;
};

/// Cut from the chain that runs through the junction.
Geometry chain_through(const NetworkPlan& plan, const JunctionEnd& from, const JunctionEnd& to) {
  const Stretch& stretch = plan.junctions.stretches[from.stretch];
  const ChainGeometry& chain = plan.geometry[stretch.chain];
  const bool reversed = from.at_begin;  // then the chain is driven against its direction
  double s0 = reversed ? to.chain_s : from.chain_s, s1 = reversed ? from.chain_s : to.chain_s;
  if (s1 <= s0) s1 += chain.length_m;  // a closed chain's first stretch follows its last one
  Geometry result{slice_plan(chain.plan, s0, s1), slice_profile(chain.elevation, s0, s1),
                  slice_profile(chain.superelevation, s0, s1), slice_profile(chain.crown, s0, s1)};
  if (!reversed) return result;
  const double length = plan_length(result.plan);
  return {reverse_plan(result.plan), reverse_profile(result.elevation, length),
          reverse_profile(result.superelevation, length, -1.0), reverse_profile(result.crown, length)};
}

Geometry turn_geometry(std::vector<roadquery::PlanElement> line, const Gate& in, const Gate& out) {
  Geometry result;
  result.plan = std::move(line);
  const double length = plan_length(result.plan);
  result.elevation = {hermite(0.0, length, in.z_m, out.z_m, in.gradient, out.gradient)};
  if (in.banking != 0.0 || out.banking != 0.0 || in.banking_rate != 0.0 || out.banking_rate != 0.0)
    result.superelevation = {hermite(0.0, length, in.banking, out.banking, in.banking_rate, out.banking_rate)};
  // Straight: a crown of two entries. The kink at the ends is one at walking pace.
  if (in.crown != 0.0 || out.crown != 0.0) result.crown = {{0.0, in.crown, (out.crown - in.crown) / length, 0.0, 0.0}};
  return result;
}

/// Lanes of a movement at a gate, from its reference line, in driving direction.
struct LaneSpan {
  double left_t = 0.0, right_t = 0.0;
};
LaneSpan span_of(const Gate& gate, std::size_t first, std::size_t count, DrivingSide driving_side) {
  const double side = driving_side == DrivingSide::left ? 1.0 : -1.0;
  const std::size_t last = first + std::max<std::size_t>(count, 1) - 1;
  const double inner = gate.inner_t_m + side * lane_from_m(gate, first);
  const double outer = gate.inner_t_m + side * (lane_from_m(gate, last) + lane_width_m(gate, last));
  return {std::max(inner, outer), std::min(inner, outer)};
}

/// Least 1 - k t of where cars drive on a road's lanes, a quarter of a lane off their edges: not positive where that
/// folds, beyond the centre of curvature.
double least_room(const std::vector<roadquery::PlanElement>& plan, const LaneSpan& in, const LaneSpan& out) {
  double least = 1.0;
  const double length = plan_length(plan);
  for (const roadquery::PlanElement& e : plan)
    for (const double ds : {0.0, 0.5 * e.length, e.length}) {
      const double k = roadquery::evaluate(e, ds).curvature, share = (e.s + ds) / length;
      for (const double t :
           {in.left_t + (out.left_t - in.left_t) * share, in.right_t + (out.right_t - in.right_t) * share})
        least = std::min(least, 1.0 - k * t);
    }
  return least;
}

/// The gate with its reference line moved to t, on the straight line between the edges of the lanes there.
Gate moved_to(Gate gate, double t, const LaneSpan& lanes, const Road& road, bool at_end, bool incoming) {
  const double s = at_end ? road.length : 0.0, sign = at_end == incoming ? 1.0 : -1.0;
  const ProfileEnd end = end_beside(road, at_end, sign, t, {lanes.left_t, lanes.right_t});
  const roadquery::SurfacePoint left = roadquery::surface_point(road, s, sign * lanes.left_t),
                                right = roadquery::surface_point(road, s, sign * lanes.right_t);
  const double share = (t - lanes.right_t) / (lanes.left_t - lanes.right_t);
  gate.z_m = end.z, gate.gradient = end.gradient, gate.banking = end.banking;
  gate.pose.p = Vec2{right.x, right.y} + Vec2{left.x - right.x, left.y - right.y} * share;
  gate.banking_rate = gate.crown = 0.0;
  // Across a crown the lanes' edges lie further apart than their widths say, which count along its slopes.
  const double stretch =
      distance_across_m(road, s, sign, {lanes.left_t, lanes.right_t}) / (lanes.left_t - lanes.right_t);
  gate.inner_t_m = (gate.inner_t_m - t) * stretch;
  for (double& width_m : gate.lane_widths_m) width_m *= stretch;
  for (double& from_m : gate.lanes_from_m) from_m *= stretch;
  return gate;
}

/// Where the lanes of a turn would fold the reference line moves to their edge on the inside of the bend, so that all
/// of them lie outside of it, or to their middle where it bends both ways. OpenDRIVE asks for lanes that meet, not for
/// reference lines that do.
void unfold(const Movement& m, const Road& incoming, bool from_end, const Road& outgoing, bool to_end,
            DrivingSide driving_side, Gate& in, Gate& out, Geometry& geometry) {
  constexpr double enough = 0.05;
  const LaneSpan at_in = span_of(in, m.first_in, m.count_in, driving_side),
                 at_out = span_of(out, m.first_out, m.count_out, driving_side);
  const auto driven = [](const LaneSpan& lanes, const Gate& gate, double t) {
    const double inset = 0.25 * lane_width_m(gate, 0);
    return LaneSpan{lanes.left_t - t - inset, lanes.right_t - t + inset};
  };
  double best = least_room(geometry.plan, driven(at_in, in, 0.0), driven(at_out, out, 0.0));
  if (best >= enough) return;
  const Gate in_before = in, out_before = out;
  for (const double share : {0.0, 0.5, 1.0}) {  // from the left edge of the lanes to the right one
    const double t0 = at_in.left_t + share * (at_in.right_t - at_in.left_t);
    const double t1 = at_out.left_t + share * (at_out.right_t - at_out.left_t);
    const Gate from = moved_to(in_before, t0, at_in, incoming, from_end, true),
               to = moved_to(out_before, t1, at_out, outgoing, to_end, false);
    if (distance(from.pose.p, to.pose.p) < shortest_turn_m) continue;
    Geometry turned = turn_geometry(turn_from(from.pose, to.pose), from, to);
    const double room = least_room(turned.plan, driven(at_in, in_before, t0), driven(at_out, out_before, t1));
    if (room <= best) continue;
    best = room, in = from, out = to, geometry = std::move(turned);
  }
}

/// What lies beside the lanes goes on along the way straight on, if that has the outermost lanes. Nobody parks there.
void add_connecting_rests(Road& road, const Movement& m, const Gate& in, const Gate& out) {
  roadquery::LaneSection& section = road.sections.front();
  const bool left_side = road.driving_side == DrivingSide::left;
  const auto add = [&](bool left, double w0, double w1) {
    if (w0 <= 0.0 && w1 <= 0.0) return;
    std::vector<roadquery::Lane>& lanes = left ? section.left : section.right;
    const int number = static_cast<int>(lanes.size()) + 1;
    roadquery::Lane lane{.id = left ? number : -number, .type = roadquery::LaneType::border};
    lane.width = ease_along(road.plan, w0, w1);
    lane.marks.push_back({0.0, "none", 0.0});
    lanes.push_back(std::move(lane));
  };
  if (m.first_in + m.count_in == in.lanes.size() && m.first_out + m.count_out == out.lanes.size())
    add(left_side, in.outer_rest_m, out.outer_rest_m);
  if (m.first_in == 0 && m.first_out == 0) add(!left_side, in.inner_rest_m, out.inner_rest_m);
}

void add_connecting_lanes(Road& road, const Movement& m, const Gate& in, const Gate& out) {
  const double side = road.driving_side == DrivingSide::left ? 1.0 : -1.0;
  const auto inner_t = [side](const Gate& gate, std::size_t first) {
    return gate.inner_t_m + side * lane_from_m(gate, first);
  };
  const double t0 = inner_t(in, m.first_in), t1 = inner_t(out, m.first_out);
  if (t0 != 0.0 || t1 != 0.0) road.lane_offset = ease_along(road.plan, t0, t1);
  roadquery::LaneSection section;
  section.center.type = roadquery::LaneType::none;
  section.center.marks.push_back({0.0, "none", 0.0});
  for (std::size_t i = 0; i < std::max(m.count_in, m.count_out); ++i) {
    roadquery::Lane lane;
    lane.id = static_cast<int>(side) * (static_cast<int>(i) + 1);
    lane.type = in.type != roadquery::LaneType::driving ? in.type : out.type;
    lane.width = ease_along(road.plan, i < m.count_in ? lane_width_m(in, m.first_in + i) : 0.0,
                            i < m.count_out ? lane_width_m(out, m.first_out + i) : 0.0);
    if (i < m.count_in) lane.predecessor = in.lanes[m.first_in + i];
    if (i < m.count_out) lane.successor = out.lanes[m.first_out + i];
    lane.marks.push_back({0.0, "none", 0.0});
    (road.driving_side == DrivingSide::left ? section.left : section.right).push_back(std::move(lane));
  }
  road.sections.push_back(std::move(section));
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

/// The way of a movement along the chains, from cut to cut.
std::vector<Leg> legs_of(const NetworkPlan& plan, const JunctionEnd& from, const JunctionEnd& to, const Movement& m) {
  const auto node_s = [&](const JunctionEnd& end) {
    const Stretch& stretch = plan.junctions.stretches[end.stretch];
    return end.at_begin ? stretch.s0 : stretch.s1;
  };
  const auto chain_of = [&](const JunctionEnd& end) { return plan.junctions.stretches[end.stretch].chain; };
  std::vector<Leg> legs{{chain_of(from), from.chain_s, node_s(from)}};
  legs.insert(legs.end(), m.legs.begin(), m.legs.end());
  legs.push_back({chain_of(to), node_s(to), to.chain_s});
  return legs;
}

Road connecting_road(const NetworkPlan& plan, const RoadMap& map, const std::vector<JunctionEnd>& ends,
                     const Movement& m, int level, Gate in, Gate out) {
  const JunctionEnd &from = ends[as_index(m.from)], &to = ends[as_index(m.to)];
  const Road &incoming = map.roads[as_index(from.road)], &outgoing = map.roads[as_index(to.road)];
  Road road;
  road.driving_side = plan.options.driving_side;
  road.highway = road_rank(incoming.highway) <= road_rank(outgoing.highway) ? incoming.highway : outgoing.highway;
  road.layer = level;
  road.speed_limit_mps = std::min(incoming.speed_limit_mps, outgoing.speed_limit_mps);
  road.bridge = level > 0 && incoming.bridge && outgoing.bridge;
  road.tunnel = level < 0 && incoming.tunnel && outgoing.tunnel;
  if (incoming.osm_id == outgoing.osm_id) road.osm_id = incoming.osm_id;
  const bool through = m.to == from.through;
  Geometry geometry =
      through
          ? chain_through(plan, from, to)
          : turn_geometry(connecting_line(plan.geometry, legs_of(plan, from, to, m), road.speed_limit_mps), in, out);
  if (!through) unfold(m, incoming, from.at_end, outgoing, to.at_end, plan.options.driving_side, in, out, geometry);
  road.plan = std::move(geometry.plan);
  road.elevation = std::move(geometry.elevation);
  road.superelevation = std::move(geometry.superelevation);
  road.length = plan_length(road.plan);
  road.predecessor = {LinkKind::road, incoming.id, from.at_end ? ContactPoint::end : ContactPoint::start};
  road.successor = {LinkKind::road, outgoing.id, to.at_end ? ContactPoint::end : ContactPoint::start};
  add_connecting_lanes(road, m, in, out);
  if (through) add_connecting_rests(road, m, in, out);
  // The larger road's surface runs through the junction.
  const bool of_incoming = road_rank(incoming.highway) >= road_rank(outgoing.highway);
  set_material(road, surface_of(of_incoming ? incoming : outgoing), plan.options.weather);
  add_crown(road, geometry.crown, plan.options.shape_tolerance_m,
            through ? max_rate_jump_of(road) : max_crown_rate_jump_in_turns);
  return road;
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
    std::vector<Movement> movements, sharp;
    for (std::size_t from = 0; from < ends[j].size(); ++from) {
      std::vector<Movement> on = movements_from(plan, rules, inside[j], ends[j], in, out, from, sharp, followed);
      for (std::size_t i = 0; i < on.size(); ++i) {
        const std::size_t lanes = in[from].lanes.size(), lanes_on = out[as_index(on[0].to)].lanes.size();
        choose_lanes(on[i], i == 0, on[0].turn_rad, lanes - std::min(lanes, lanes_on), in[from],
                     out[as_index(on[i].to)], plan.options.driving_side);
        movements.push_back(on[i]);
      }
    }
    for (Movement& m : only_ways_in(movements, sharp, ends[j].size())) {
      choose_lanes(m, false, 0.0, 0, in[as_index(m.from)], out[as_index(m.to)], plan.options.driving_side);
      movements.push_back(m);
    }
    report_left_out(plan, ends[j], in, movements, sharp, findings);
    feed_all_lanes(ends[j], out, movements);
    keep_lanes_that_have_room(plan, ends[j], in, out, movements, findings);
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
