// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/evaluate_network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <vector>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/evaluate/labels/no_value.hpp"
#include "orthodrive/evaluate/networks/inner_border.hpp"
#include "orthodrive/evaluate/networks/lane_links.hpp"
#include "orthodrive/evaluate/networks/measure_clearance.hpp"
#include "orthodrive/geo/angle.hpp"
#include "roadquery/opendrive/broken_links.hpp"
#include "roadquery/roads/road_ends.hpp"
#include "roadquery/surface/surface_gradient.hpp"

namespace orthodrive {
namespace {
using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadEnd;
using roadquery::RoadMap;
using roadquery::RoadsById;

void count_elements(const RoadMap& map, NetworkScores& scores) {
  constexpr const char* kinds[] = {"line", "arc", "spiral", "paramPoly3"};  // order of roadquery::PlanShape
  for (const char* kind : kinds) scores.elements[kind] = 0;
  scores.roads = map.roads.size();
  scores.junctions = map.junctions.size();
  for (const Road& road : map.roads) {
    scores.connecting_roads += road.junction >= 0 ? 1 : 0;
    scores.length_m += road.length;
    for (const roadquery::PlanElement& element : road.plan) ++scores.elements[kinds[element.shape.index()]];
    if (road.junction >= 0) continue;
    scores.road_length_m += road.length;
    scores.road_elements += road.plan.size();
  }
  scores.mean_road_element_m =
      scores.road_elements > 0 ? scores.road_length_m / static_cast<double>(scores.road_elements) : no_value;
}

/// Of clothoids exactly, of cubics in 20 steps.
double curvature_rate(const roadquery::PlanElement& element) {
  if (std::holds_alternative<roadquery::Line>(element.shape) || std::holds_alternative<roadquery::Arc>(element.shape))
    return 0.0;
  const int steps = std::holds_alternative<roadquery::Spiral>(element.shape) ? 1 : 20;
  const double step_m = element.length / steps;
  double largest = 0.0;
  for (int i = 0; i < steps; ++i)
    largest = std::max(largest, std::abs(roadquery::evaluate(element, (i + 1) * step_m).curvature -
                                         roadquery::evaluate(element, i * step_m).curvature) /
                                    step_m);
  return largest;
}

double gradient_kink(const Road& road) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < road.elevation.size(); ++i) {
    const roadquery::Cubic &before = road.elevation[i], &after = road.elevation[i + 1];
    const double ds = after.s - before.s;
    largest = std::max(largest, std::abs(after.b - (before.b + ds * (2.0 * before.c + 3.0 * ds * before.d))));
  }
  return largest;
}

double element_gap_m(const Road& road) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < road.plan.size(); ++i) {
    const roadquery::PlanPoint end = roadquery::evaluate(road.plan[i], road.plan[i].length);
    largest = std::max(largest, std::hypot(end.x - road.plan[i + 1].x, end.y - road.plan[i + 1].y));
  }
  return largest;
}

double distance_m(const roadquery::SurfacePoint& a, const roadquery::SurfacePoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

/// Where lanes are linked the best of them counts: a connecting road's reference line need not meet that of the road,
/// and lanes of different width have one common border at most. A gap of the roads shows in all lanes.
double link_gap_m(const RoadEnd& from, const RoadEnd& to) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto* side : {&from.section().left, &from.section().right})
    for (const roadquery::Lane& lane : *side) {
      const std::optional<int>& linked = from.contact == ContactPoint::start ? lane.predecessor : lane.successor;
      if (linked && roadquery::find_lane(to.section(), *linked))
        smallest =
            std::min(smallest, distance_m(evaluate::inner_border(from, lane.id), evaluate::inner_border(to, *linked)));
    }
  if (std::isfinite(smallest)) return smallest;
  return distance_m(roadquery::surface_point(*from.road, from.s(), 0.0),
                    roadquery::surface_point(*to.road, to.s(), 0.0));
}

void measure_plan(const Road& road, NetworkScores& scores) {
  if (road.junction < 0)
    for (const roadquery::PlanElement& element : road.plan)
      scores.max_curvature_rate = std::max(scores.max_curvature_rate, curvature_rate(element));
  for (std::size_t i = 0; i + 1 < road.plan.size(); ++i) {
    const roadquery::PlanPoint a = roadquery::evaluate(road.plan[i], road.plan[i].length);
    const roadquery::PlanPoint b = roadquery::evaluate(road.plan[i + 1], 0.0);
    scores.max_heading_jump_rad = std::max(scores.max_heading_jump_rad, std::abs(wrapped_angle(a.hdg - b.hdg)));
    if (road.junction < 0)
      scores.max_curvature_jump = std::max(scores.max_curvature_jump, std::abs(a.curvature - b.curvature));
  }
}

/// Gradient along the heading of the reference line at t of a road's end: of the reference line itself where t is 0.
double gradient_beside(const RoadEnd& end, const roadquery::PlanPoint& p, double t) {
  constexpr double on_line_m = 1e-3;
  if (std::abs(t) < on_line_m) return roadquery::gradient(*end.road, end.s());
  return roadquery::gradient_towards(roadquery::surface_point(*end.road, end.s(), t), p.hdg);
}

/// Heading, gradient and curvature of a car that goes along the reference line of the one road into the other. The
/// reference line of a connecting road may lie beside that of the road.
void measure_link(const RoadEnd& from, const RoadEnd& to, NetworkScores& scores) {
  const roadquery::PlanPoint a = roadquery::reference_point(*from.road, from.s());
  const roadquery::PlanPoint b = roadquery::reference_point(*to.road, to.s());
  const bool a_along = from.contact == ContactPoint::end, b_along = to.contact == ContactPoint::start;
  const double a_sign = a_along ? 1.0 : -1.0, b_sign = b_along ? 1.0 : -1.0;
  const double heading_a = a.hdg + (a_along ? 0.0 : std::numbers::pi);
  const double heading_b = b.hdg + (b_along ? 0.0 : std::numbers::pi);
  const double left_m = std::cos(b.hdg) * (a.y - b.y) - std::sin(b.hdg) * (a.x - b.x);
  const double t = roadquery::t_at(*to.road, to.s(), left_m);
  const double gradient_a = a_sign * gradient_beside(from, a, 0.0), gradient_b = b_sign * gradient_beside(to, b, t);
  scores.max_heading_jump_rad = std::max(scores.max_heading_jump_rad, std::abs(wrapped_angle(heading_a - heading_b)));
  scores.max_gradient_kink = std::max(scores.max_gradient_kink, std::abs(gradient_a - gradient_b));
  if (from.road->junction < 0 && to.road->junction < 0)
    scores.max_curvature_jump =
        std::max(scores.max_curvature_jump, std::abs(a_sign * a.curvature - b_sign * b.curvature));
}

/// Ids of the roads that a junction's connections come from or lead to.
std::set<int> roads_at(const RoadMap& map, const roadquery::Junction& junction, const RoadsById& by_id) {
  std::set<int> roads;
  for (const roadquery::Connection& connection : junction.connections) {
    roads.insert({connection.incoming_road, connection.connecting_road});  // of a direct junction that is the other one
    const auto via = by_id.find(connection.connecting_road);
    if (!via) continue;
    for (const roadquery::RoadLink* link : {&map.roads[*via].predecessor, &map.roads[*via].successor})
      if (link->kind == LinkKind::road) roads.insert(link->id);
  }
  return roads;
}

void measure_joints(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  std::map<int, std::set<int>> roads_of_junction;
  for (const roadquery::Junction& junction : map.junctions)
    roads_of_junction[junction.id] = roads_at(map, junction, by_id);
  for (const Road& road : map.roads) {
    scores.max_gradient_kink = std::max(scores.max_gradient_kink, gradient_kink(road));
    scores.max_joint_gap_m = std::max(scores.max_joint_gap_m, element_gap_m(road));
    measure_plan(road, scores);
    for (const ContactPoint contact : {ContactPoint::start, ContactPoint::end}) {
      const roadquery::RoadLink& link = RoadEnd{&road, contact}.link();
      if (link.kind == LinkKind::junction) {
        const auto junction = roads_of_junction.find(link.id);
        if (junction != roads_of_junction.end() && !junction->second.contains(road.id)) ++scores.broken_links;
      }
      if (link.kind != LinkKind::road) continue;
      const auto other = by_id.find(link.id);
      if (!other) continue;
      const RoadEnd from{&road, contact}, to{&map.roads[*other], link.contact};
      scores.max_joint_gap_m = std::max(scores.max_joint_gap_m, link_gap_m(from, to));
      measure_link(from, to, scores);
      // The other side answers: with this road, or from a connecting road with its junction.
      const roadquery::RoadLink& back = to.link();
      const bool answered = road.junction >= 0
                                ? back.kind == LinkKind::junction && back.id == road.junction
                                : back.kind == LinkKind::road && back.id == road.id && back.contact == contact;
      if (!answered) ++scores.broken_links;
    }
  }
}

double connected_share(const RoadMap& map, const RoadsById& by_id) {
  DisjointSets connected(map.roads.size());
  const auto join = [&](std::size_t a, std::optional<std::size_t> b) {
    if (b) connected.join(a, *b);
  };
  for (std::size_t i = 0; i < map.roads.size(); ++i)
    for (const roadquery::RoadLink* link : {&map.roads[i].predecessor, &map.roads[i].successor})
      if (link->kind == LinkKind::road) join(i, by_id.find(link->id));
  for (const roadquery::Junction& junction : map.junctions)
    for (const roadquery::Connection& connection : junction.connections)
      if (const auto incoming = by_id.find(connection.incoming_road))
        join(*incoming, by_id.find(connection.connecting_road));
  std::vector<double> length_m(map.roads.size());
  double total_m = 0.0;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    length_m[connected.find(i)] += map.roads[i].length;
    total_m += map.roads[i].length;
  }
  return total_m > 0.0 ? *std::max_element(length_m.begin(), length_m.end()) / total_m : no_value;
}
}  // namespace

NetworkScores evaluate_network(const RoadMap& map) {
  NetworkScores scores;
  const RoadsById by_id(map);
  count_elements(map, scores);
  const auto links = roadquery::broken_links(map);  // those of lanes are counted with the lanes
  scores.broken_links = static_cast<std::size_t>(std::ranges::count_if(
      links, [](const roadquery::BrokenLink& link) { return link.kind < roadquery::BrokenLink::Kind::lane; }));
  measure_joints(map, by_id, scores);
  evaluate::check_lanes(map, by_id, scores);
  evaluate::measure_clearance(map, by_id, scores);
  scores.connected_share = connected_share(map, by_id);
  return scores;
}

}  // namespace orthodrive
