// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/junction_members.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "roadquery/surface/blend.hpp"
#include "roadquery/surface/short_ways.hpp"

namespace orthodrive::network {
namespace {

using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double near_level_m = 2.5;   // other roads nearer in height share the ground
constexpr double kerb_reach_m = 12.0;  // the largest kerb radius
constexpr double boundary_step_m = 1.0, height_step_m = 2.0;

Box2 box_of(const Road& road) { return RoadCover(road, {}, 0.0, road.length).bounds(); }

double middle_height(const Road& road) { return roadquery::elevation(road, 0.5 * road.length); }

bool is_among(const std::vector<std::size_t>& list, std::size_t i) {
  return std::find(list.begin(), list.end(), i) != list.end();
}

std::vector<JunctionMembers> linked_roads(const RoadMap& map) {
  std::map<int, std::size_t> place;
  for (std::size_t j = 0; j < map.junctions.size(); ++j) place[map.junctions[j].id] = j;
  std::vector<JunctionMembers> members(map.junctions.size());
  const auto junction_at = [&](const roadquery::RoadLink& link) {
    const auto found = link.kind == LinkKind::junction ? place.find(link.id) : place.end();
    return found != place.end() ? &members[found->second] : nullptr;
  };
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road& road = map.roads[i];
    if (road.junction >= 0) {
      if (const auto found = place.find(road.junction); found != place.end() && road.length > 0.0)
        members[found->second].connecting.push_back(i);
      continue;
    }
    JunctionMembers *at_start = junction_at(road.predecessor), *at_end = junction_at(road.successor);
    if (at_start) at_start->arms.push_back(i), at_start->at_end.push_back(false);
    if (at_end) at_end->arms.push_back(i), at_end->at_end.push_back(true);
  }
  return members;
}

/// Short ways lie inside: they are no arms.
void find_inner_roads(const RoadMap& map, std::vector<JunctionMembers>& members) {
  std::map<int, std::size_t> place;
  for (std::size_t j = 0; j < map.junctions.size(); ++j) place[map.junctions[j].id] = j;
  for (const roadquery::ShortWay& way : roadquery::short_ways(map))
    for (const int id : way.junctions) {
      const auto found = place.find(id);
      if (found == place.end()) continue;
      JunctionMembers& m = members[found->second];
      for (const std::size_t i : way.roads)
        if (!is_among(m.inner, i)) m.inner.push_back(i);
    }
  for (JunctionMembers& m : members) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < m.arms.size(); ++k) {
      if (is_among(m.inner, m.arms[k])) continue;
      m.arms[kept] = m.arms[k], m.at_end[kept] = m.at_end[k];
      ++kept;
    }
    m.arms.resize(kept), m.at_end.resize(kept);
  }
}

void find_others(const RoadMap& map, std::vector<JunctionMembers>& members, int threads) {
  std::vector<Box2> boxes(map.roads.size());
  parallel_for(map.roads.size(), threads, [&](std::size_t i) { boxes[i] = box_of(map.roads[i]); });
  const SpatialIndex index(boxes);
  for (JunctionMembers& m : members) {
    if (m.connecting.empty()) continue;
    Box2 box = boxes[m.connecting.front()];
    double z = 0.0;
    for (const std::size_t i : m.connecting) {
      box = {std::min(box.min_x, boxes[i].min_x), std::min(box.min_y, boxes[i].min_y),
             std::max(box.max_x, boxes[i].max_x), std::max(box.max_y, boxes[i].max_y)};
      z += middle_height(map.roads[i]) / static_cast<double>(m.connecting.size());
    }
    for (const std::size_t i : index.touching(box.grown(kerb_reach_m))) {
      const Road& road = map.roads[i];
      const std::array heights{middle_height(road), roadquery::elevation(road, 0.0),
                               roadquery::elevation(road, road.length)};
      const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
      if (*low > z + near_level_m || *high < z - near_level_m || is_among(m.connecting, i) || is_among(m.arms, i) ||
          is_among(m.inner, i))
        continue;
      m.others.push_back(i);
    }
  }
}

/// What tells whether two areas lie on one ground.
struct Ground {
  Ring boundary;  ///< absolute, points at most a metre apart
  Box2 box;
  std::vector<Vec2> places;  ///< along the connecting roads
  std::vector<double> z;
};

Ground ground_of(const RoadMap& map, const JunctionMembers& members, const JunctionGround& area) {
  Ground ground;
  for (std::size_t i = 0; i < area.boundary.size(); ++i) {
    const Vec2 a = area.boundary[i] + area.origin, b = area.boundary[(i + 1) % area.boundary.size()] + area.origin;
    const int steps = std::max(1, static_cast<int>(std::ceil(distance(a, b) / boundary_step_m)));
    for (int k = 0; k < steps; ++k) ground.boundary.push_back(a + (b - a) * (static_cast<double>(k) / steps));
  }
  if (!ground.boundary.empty()) ground.box = bounds_of(ground.boundary);
  for (const std::size_t i : members.connecting) {
    const Road& road = map.roads[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(road.length / height_step_m)));
    for (int k = 0; k <= steps; ++k) {
      const double s = road.length * k / steps;
      const roadquery::PlanPoint p = roadquery::reference_point(road, s);
      ground.places.push_back({p.x, p.y}), ground.z.push_back(roadquery::elevation(road, s));
    }
  }
  return ground;
}

double height_near(const Ground& ground, Vec2 p) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < ground.places.size(); ++i)
    if (distance(ground.places[i], p) < distance(ground.places[nearest], p)) nearest = i;
  return ground.z[nearest];
}

bool overlap(const Ground& a, const Ground& b) {
  const Polygon of_b{b.boundary, {}};
  return std::any_of(a.boundary.begin(), a.boundary.end(), [&](Vec2 p) {
    return b.box.contains(p) && contains(of_b, p) && roadquery::is_same_level(height_near(a, p), height_near(b, p));
  });
}

}  // namespace

std::vector<JunctionMembers> junction_members(const RoadMap& map, int threads) {
  std::vector<JunctionMembers> members = linked_roads(map);
  find_inner_roads(map, members);
  find_others(map, members, threads);
  return members;
}

JunctionRoads roads_of(const RoadMap& map, const JunctionMembers& members) {
  JunctionRoads roads;
  for (const std::size_t i : members.connecting) roads.connecting.push_back(&map.roads[i]);
  for (const std::size_t i : members.inner) roads.connecting.push_back(&map.roads[i]);
  for (std::size_t k = 0; k < members.arms.size(); ++k) {
    roads.arms.push_back(&map.roads[members.arms[k]]), roads.at_end.push_back(members.at_end[k]);
  }
  for (const std::size_t i : members.others) roads.others.push_back(&map.roads[i]);
  return roads;
}

std::vector<std::vector<std::size_t>> junctions_on_one_ground(const RoadMap& map,
                                                              const std::vector<JunctionMembers>& members,
                                                              const std::vector<JunctionGround>& grounds) {
  DisjointSets together(members.size());
  std::map<std::size_t, std::size_t> junction_of_inner;
  std::vector<Ground> of_junction(members.size());
  std::vector<Box2> boxes;
  std::vector<std::size_t> with_area;
  for (std::size_t j = 0; j < members.size(); ++j) {
    if (grounds[j].boundary.empty()) continue;
    of_junction[j] = ground_of(map, members[j], grounds[j]);
    boxes.push_back(of_junction[j].box), with_area.push_back(j);
    for (const std::size_t road : members[j].inner)
      if (const auto [other, is_new] = junction_of_inner.emplace(road, j); !is_new) together.join(other->second, j);
  }
  const SpatialIndex index(boxes);
  for (std::size_t k = 0; k < with_area.size(); ++k)
    for (const std::size_t near : index.touching(boxes[k])) {
      const std::size_t a = with_area[k], b = with_area[near];
      if (a >= b || together.find(a) == together.find(b)) continue;
      if (overlap(of_junction[a], of_junction[b]) || overlap(of_junction[b], of_junction[a])) together.join(a, b);
    }
  std::map<std::size_t, std::vector<std::size_t>> groups;
  for (const std::size_t j : with_area) groups[together.find(j)].push_back(j);
  std::vector<std::vector<std::size_t>> result;
  result.reserve(groups.size());
  for (auto& [_, group] : groups) result.push_back(std::move(group));
  return result;
}

}  // namespace orthodrive::network
