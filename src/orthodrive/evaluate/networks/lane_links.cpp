// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/lane_links.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "orthodrive/evaluate/networks/inner_border.hpp"

namespace orthodrive::evaluate {
namespace {
using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadEnd;
using roadquery::RoadMap;
using roadquery::RoadsById;

bool drives_along(const Road& road, int lane) {
  return (lane < 0) != (road.driving_side == roadquery::DrivingSide::left);
}

/// Whether one lane may go on as the other: the same, or both for vehicles of some kind. A lane for cars that goes on
/// as one for buses alone is a lane that cars have to leave.
bool goes_on_as(roadquery::LaneType from, roadquery::LaneType to) {
  using roadquery::LaneType;
  const auto is_lane = [](LaneType type) {
    return roadquery::is_driven(type) || type == LaneType::bus || type == LaneType::taxi || type == LaneType::biking ||
           type == LaneType::other;
  };
  return from == to || (is_lane(from) && is_lane(to));
}

/// A lane that has narrowed to nothing has merged with the one beside it and is not dead.
void add_dead_lane(const RoadEnd& end, const roadquery::Lane& lane, NetworkScores& scores) {
  constexpr double merged_m = 0.01;
  if (roadquery::lane_width(lane, end.s() - end.section().s) < merged_m) return;
  const roadquery::SurfacePoint p = inner_border(end, lane.id);
  scores.dead_lane_places.push_back({end.road->id, lane.id, p.x, p.y});
  ++scores.dead_lanes;
}

/// Lanes of a road end against those that they are linked to.
void check_end_lanes(const RoadEnd& from, const RoadEnd* to, bool in_junction, NetworkScores& scores) {
  using roadquery::LaneType;
  for (const auto* side : {&from.section().left, &from.section().right})
    for (const roadquery::Lane& lane : *side) {
      const bool at_end = from.contact == ContactPoint::end;
      const std::optional<int>& linked = at_end ? lane.successor : lane.predecessor;
      if (!linked) {
        const bool leaves = drives_along(*from.road, lane.id) == at_end;
        if (to && leaves && lane.type == LaneType::driving && !in_junction) add_dead_lane(from, lane, scores);
        continue;
      }
      const roadquery::Lane* other = to ? roadquery::find_lane(to->section(), *linked) : nullptr;
      if (!other || !goes_on_as(lane.type, other->type)) {
        ++scores.lane_link_errors;
        continue;
      }
      const bool same_s = (from.contact == ContactPoint::end) != (to->contact == ContactPoint::end);
      const bool either_way = lane.type == LaneType::bidirectional || other->type == LaneType::bidirectional;
      if (!either_way && (drives_along(*from.road, lane.id) == drives_along(*to->road, *linked)) != same_s)
        ++scores.lane_link_errors;
      if (in_junction || to->road->junction >= 0) continue;
      const std::optional<int>& back = to->contact == ContactPoint::end ? other->successor : other->predecessor;
      if (back != lane.id) ++scores.lane_link_errors;
    }
}

/// At its start, middle or end: many lanes taper.
double widest_m(const roadquery::Lane& lane, double length) {
  return std::max({roadquery::lane_width(lane, 0.0), roadquery::lane_width(lane, 0.5 * length),
                   roadquery::lane_width(lane, length)});
}

/// Links between roads, and the narrowest lane.
void check_roads(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  for (const Road& road : map.roads) {
    for (const ContactPoint contact : {ContactPoint::start, ContactPoint::end}) {
      const roadquery::RoadLink& link = RoadEnd{&road, contact}.link();
      const auto other = link.kind == LinkKind::road ? by_id.find(link.id) : std::nullopt;
      const RoadEnd from{&road, contact}, to{other ? &map.roads[*other] : nullptr, link.contact};
      check_end_lanes(from, other ? &to : nullptr, road.junction >= 0, scores);
    }
    if (road.junction >= 0) continue;
    for (const roadquery::LaneSection& section : road.sections)
      for (const auto* side : {&section.left, &section.right})
        for (const roadquery::Lane& lane : *side)
          if (roadquery::is_driven(lane.type))
            scores.min_lane_width_m = std::fmin(scores.min_lane_width_m, widest_m(lane, road.length - section.s));
  }
}

/// Lane links of a junction against the lanes of its connecting roads, and lanes that lead in and not on.
void check_junction(const RoadMap& map, const roadquery::Junction& junction, const RoadsById& by_id,
                    NetworkScores& scores) {
  struct Fed {
    const Road* road = nullptr;
    std::set<int> lanes;
  };
  std::map<int, Fed> fed;  // the roads that lead in, by their ids
  for (const roadquery::Connection& connection : junction.connections) {
    const auto incoming = by_id.find(connection.incoming_road), via = by_id.find(connection.connecting_road);
    if (!incoming || !via) continue;
    const RoadEnd connecting{&map.roads[*via], connection.contact};
    for (const roadquery::LaneLink& link : connection.lane_links) {
      const roadquery::Lane* lane = roadquery::find_lane(connecting.section(), link.to);
      const std::optional<int> expected = !lane                                       ? std::nullopt
                                          : connection.contact == ContactPoint::start ? lane->predecessor
                                                                                      : lane->successor;
      if (expected != link.from) ++scores.lane_link_errors;
      Fed& from = fed[connection.incoming_road];
      from.road = &map.roads[*incoming];
      from.lanes.insert(link.from);
    }
  }
  for (const auto& [id, incoming] : fed) {
    const Road& road = *incoming.road;
    for (const ContactPoint contact : {ContactPoint::start, ContactPoint::end}) {
      const roadquery::RoadLink& link = RoadEnd{&road, contact}.link();
      if (link.kind != LinkKind::junction || link.id != junction.id) continue;
      const RoadEnd end{&road, contact};
      for (const auto* side : {&end.section().left, &end.section().right})
        for (const roadquery::Lane& lane : *side)
          if (lane.type == roadquery::LaneType::driving &&
              drives_along(road, lane.id) == (contact == ContactPoint::end) && incoming.lanes.count(lane.id) == 0)
            add_dead_lane(end, lane, scores);
    }
  }
}
}  // namespace

void check_lanes(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  scores.min_lane_width_m = std::numeric_limits<double>::quiet_NaN();
  check_roads(map, by_id, scores);
  for (const roadquery::Junction& junction : map.junctions) check_junction(map, junction, by_id, scores);
}

}  // namespace orthodrive::evaluate
