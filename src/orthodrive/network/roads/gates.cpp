// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/roads/gates.hpp"

#include <algorithm>

#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Road;

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

}  // namespace

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

double lane_from_m(const Gate& gate, std::size_t lane) {
  if (lane < gate.lanes_from_m.size()) return gate.lanes_from_m[lane];
  return gate.lanes_from_m.empty() ? 0.0 : gate.lanes_from_m.back() + gate.lane_widths_m.back();
}
double lane_width_m(const Gate& gate, std::size_t lane) {
  return lane < gate.lane_widths_m.size() ? gate.lane_widths_m[lane] : 0.0;
}

}  // namespace orthodrive::network
