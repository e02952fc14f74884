#include "orthodrive/scene/crossing_roads.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double apart_m = 1.5, step_m = 2.0;

/// The middle of a road, every 2 m.
std::vector<Vec3> middle_of(const roadquery::Road& road) {
  std::vector<Vec3> line;
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
  for (int i = 0; i <= steps; ++i) {
    const double s = road.length * i / steps;
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    const auto p = roadquery::surface_point(road, s, 0.5 * (edges.left_t + edges.right_t));
    line.push_back({p.x, p.y, p.z});
  }
  return line;
}

/// Difference in height where two pieces of line cross in plan; 0 where they do not.
double height_between(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec2 ab{b.x - a.x, b.y - a.y}, cd{d.x - c.x, d.y - c.y}, ac{c.x - a.x, c.y - a.y};
  const double area = cross(ab, cd);
  if (area == 0.0) return 0.0;
  const double u = cross(ac, cd) / area, v = cross(ac, ab) / area;
  if (u < 0.0 || u > 1.0 || v < 0.0 || v > 1.0) return 0.0;
  return std::abs(a.z + u * (b.z - a.z) - c.z - v * (d.z - c.z));
}

/// Pairs of roads, the first one before the second, that cross with more than 1.5 m between them.
std::set<std::pair<std::size_t, std::size_t>> crossings_of(std::span<const roadquery::Road* const> roads) {
  struct Piece {
    std::size_t road;
    Vec3 a, b;
  };
  std::vector<Piece> pieces;
  std::vector<Box2> boxes;
  for (std::size_t i = 0; i < roads.size(); ++i) {
    const std::vector<Vec3> line = middle_of(*roads[i]);
    for (std::size_t k = 1; k < line.size(); ++k) {
      const Vec3 &a = line[k - 1], &b = line[k];
      pieces.push_back({i, a, b});
      boxes.push_back({std::min(a.x, b.x), std::min(a.y, b.y), std::max(a.x, b.x), std::max(a.y, b.y)});
    }
  }
  const SpatialIndex index(boxes);
  std::set<std::pair<std::size_t, std::size_t>> crossings;
  for (std::size_t p = 0; p < pieces.size(); ++p)
    for (const std::uint32_t q : index.touching(boxes[p]))
      if (pieces[p].road < pieces[q].road &&
          height_between(pieces[p].a, pieces[p].b, pieces[q].a, pieces[q].b) > apart_m)
        crossings.emplace(pieces[p].road, pieces[q].road);
  return crossings;
}

/// For each road the first one that it is joined with, over links or a junction.
std::vector<std::size_t> joined_roads(std::span<const roadquery::Road* const> roads) {
  DisjointSets joined(roads.size());
  std::map<int, std::size_t> by_id, by_junction;
  for (std::size_t i = 0; i < roads.size(); ++i) by_id.emplace(roads[i]->id, i);
  for (std::size_t i = 0; i < roads.size(); ++i) {
    if (roads[i]->junction >= 0) joined.join(i, by_junction.emplace(roads[i]->junction, i).first->second);
    for (const roadquery::RoadLink& link : {roads[i]->predecessor, roads[i]->successor}) {
      if (link.kind == roadquery::LinkKind::road) {
        if (const auto found = by_id.find(link.id); found != by_id.end()) joined.join(i, found->second);
      } else if (link.kind == roadquery::LinkKind::junction) {
        joined.join(i, by_junction.emplace(link.id, i).first->second);
      }
    }
  }
  std::vector<std::size_t> first(roads.size());
  for (std::size_t i = 0; i < roads.size(); ++i) first[i] = joined.find(i);
  return first;
}

}  // namespace

std::vector<std::vector<const roadquery::Road*>> told_apart(std::span<const roadquery::Road* const> roads) {
  const auto crossings = crossings_of(roads);
  std::vector<std::size_t> group = joined_roads(roads);
  std::set<std::size_t> torn;  // groups that cross themselves
  for (const auto& [a, b] : crossings)
    if (group[a] == group[b]) torn.insert(group[a]);
  for (std::size_t i = 0; i < group.size(); ++i)
    if (torn.contains(group[i])) group[i] = i;
  std::map<std::size_t, std::set<std::size_t>> against;  // by group: those before it that it crosses
  for (const auto& [a, b] : crossings) against[std::max(group[a], group[b])].insert(std::min(group[a], group[b]));
  std::vector<std::vector<const roadquery::Road*>> sets;
  std::map<std::size_t, std::size_t> set_of;
  for (std::size_t i = 0; i < roads.size(); ++i) {
    const auto [at, is_new] = set_of.try_emplace(group[i], 0);
    if (is_new) {
      std::set<std::size_t> taken;
      for (const std::size_t other : against[group[i]]) taken.insert(set_of.at(other));
      while (taken.contains(at->second)) ++at->second;
      sets.resize(std::max(sets.size(), at->second + 1));
    }
    sets[at->second].push_back(roads[i]);
  }
  return sets;
}

}  // namespace orthodrive::scene
