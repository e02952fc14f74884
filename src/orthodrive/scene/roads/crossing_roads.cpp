// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/crossing_roads.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "orthodrive/core/disjoint_sets.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "roadquery/surface/road_surface.hpp"

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

namespace {

/// Between two cross sections; corners: left and right one of both.
struct Stretch {
  std::size_t road;
  std::array<Vec3, 4> corners;
};

bool is_finite(const Vec3& p) { return std::isfinite(p.x + p.y + p.z); }

/// Height of a stretch at p, of one of its two triangles; nothing: p lies beside it.
std::optional<double> height_of(const Stretch& stretch, Vec2 p) {
  const auto& c = stretch.corners;
  for (const auto& [a, b, d] : {std::array{c[0], c[1], c[3]}, {c[0], c[3], c[2]}}) {
    const Vec2 pa{a.x, a.y}, pb{b.x, b.y}, pd{d.x, d.y};
    const double area = cross(pb - pa, pd - pa);
    if (area == 0.0) continue;
    const double v = cross(p - pa, pd - pa) / area, w = cross(pb - pa, p - pa) / area;
    if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return a.z + v * (b.z - a.z) + w * (d.z - a.z);
  }
  return std::nullopt;
}

std::vector<Stretch> stretches_of(const roadquery::Road& road, std::size_t index) {
  std::vector<Stretch> stretches;
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
  const auto cut = [&](int i) {
    const double s = road.length * i / steps;
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    const auto left = roadquery::surface_point(road, s, edges.left_t),
               right = roadquery::surface_point(road, s, edges.right_t);
    return std::array{Vec3{left.x, left.y, left.z}, Vec3{right.x, right.y, right.z}};
  };
  auto last = cut(0);
  for (int i = 1; i <= steps; ++i) {
    const auto next = cut(i);
    const Stretch stretch{index, {last[0], last[1], next[0], next[1]}};
    if (std::ranges::all_of(stretch.corners, is_finite)) stretches.push_back(stretch);
    last = next;
  }
  return stretches;
}

}  // namespace

std::vector<bool> lying_over(std::span<const roadquery::Road> roads) {
  std::vector<Stretch> all;
  std::vector<Box2> boxes;
  for (std::size_t i = 0; i < roads.size(); ++i) {
    const roadquery::Road& road = roads[i];
    if (road.bridge || road.tunnel || road.layer > 0 || road.junction >= 0 || !(road.length > 0.0) ||
        road.plan.empty() || road.sections.empty())
      continue;
    for (const Stretch& stretch : stretches_of(road, i)) {
      const auto& c = stretch.corners;
      all.push_back(stretch);
      boxes.push_back(bounds_of({{c[0].x, c[0].y}, {c[1].x, c[1].y}, {c[2].x, c[2].y}, {c[3].x, c[3].y}}));
    }
  }
  std::vector<bool> result(roads.size(), false);
  const SpatialIndex index(boxes);
  for (const Stretch& stretch : all) {
    const auto& c = stretch.corners;
    for (const Vec3& p : {c[0], c[1], (c[0] + c[1]) * 0.5}) {
      for (const std::uint32_t k : index.touching({p.x, p.y, p.x, p.y})) {
        if (all[k].road == stretch.road) continue;
        const auto z = height_of(all[k], {p.x, p.y});
        if (z && std::abs(p.z - *z) > apart_m) result[p.z > *z ? stretch.road : all[k].road] = true;
      }
    }
  }
  return result;
}

RoadStructure structure_of(const roadquery::Road& road, bool lies_over) {
  if (road.tunnel) return RoadStructure::tunnel;
  return road.bridge || road.layer > 0 || lies_over ? RoadStructure::deck : RoadStructure::ground;
}

}  // namespace orthodrive::scene
