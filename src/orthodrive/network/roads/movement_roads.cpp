// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/roads/movement_roads.hpp"

#include <algorithm>
#include <utility>

#include "orthodrive/network/curves/crown_shape.hpp"
#include "orthodrive/network/curves/ease_along.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"
#include "orthodrive/network/junctions/refit_profile.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::ContactPoint;
using roadquery::Cubic;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

// Jumps of the gradient on connecting roads that turn, driven at walking pace: 1 % 2 m off the reference line. At 4 m/s
// a wheel gets 0.04 m/s from it, as from 0.1 % at 40 m/s.
constexpr double max_crown_rate_jump_in_turns = 5e-3;  // 1/m

constexpr double shortest_turn_m = 0.5;  // of a reference line that is moved to the inside of its bend

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

}  // namespace

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

}  // namespace orthodrive::network
