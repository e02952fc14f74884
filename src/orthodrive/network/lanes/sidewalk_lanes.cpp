// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/lanes/sidewalk_lanes.hpp"

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {

using roadquery::Lane;
using roadquery::LaneType;
using roadquery::Road;
using roadquery::RoadMap;

Lane* SidewalkLane::lane(RoadMap& map) const {
  roadquery::LaneSection& section = map.roads[road].sections.front();
  for (Lane& lane : left ? section.left : section.right)
    if (lane.type == LaneType::sidewalk) return &lane;
  return nullptr;
}

double SidewalkLane::inner_t(const Road& of, double s) const {
  const roadquery::LaneSection& section = of.sections.front();
  double t = roadquery::evaluate(of.lane_offset, s);
  for (const Lane& lane : left ? section.left : section.right) {
    if (lane.type == LaneType::sidewalk) break;
    t += (left ? 1.0 : -1.0) * roadquery::lane_width(lane, s - section.s);
  }
  return t;
}

std::vector<SidewalkLane> sidewalk_lanes(RoadMap& map) {
  std::vector<SidewalkLane> walks;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    if (map.roads[i].junction >= 0 || map.roads[i].sections.size() != 1) continue;
    for (const bool left : {true, false})
      if (const SidewalkLane walk{i, left}; walk.lane(map) != nullptr) walks.push_back(walk);
  }
  return walks;
}

std::vector<SidewalkJoint> sidewalk_joints(const RoadMap& map, const std::vector<SidewalkLane>& walks) {
  std::map<std::pair<int, bool>, std::size_t> walk_of;  // by id of the road and side
  for (std::size_t i = 0; i < walks.size(); ++i) walk_of[{map.roads[walks[i].road].id, walks[i].left}] = i;
  std::vector<SidewalkJoint> joints;
  for (std::size_t i = 0; i < walks.size(); ++i)
    for (const bool at_end : {false, true}) {
      const Road& road = map.roads[walks[i].road];
      const roadquery::RoadLink& link = at_end ? road.successor : road.predecessor;
      if (link.kind != roadquery::LinkKind::road) continue;
      const bool to_end = link.contact == roadquery::ContactPoint::end;
      const auto other = walk_of.find({link.id, walks[i].left == (at_end != to_end)});
      joints.push_back({i, other == walk_of.end() ? walks.size() : other->second, at_end, to_end});
    }
  return joints;
}

}  // namespace orthodrive::network
