// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/junctions/roads_over.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/blend.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive::network {

namespace {

bool goes_on_into(const roadquery::Road& road, const roadquery::Road& other) {
  const auto links = [&other](const roadquery::RoadLink& link) {
    return link.kind == roadquery::LinkKind::road && link.id == other.id;
  };
  return links(road.predecessor) || links(road.successor);
}

}  // namespace

RoadsOver::RoadsOver(const roadquery::RoadMap& map) : map_(map) {
  if (map.roads.empty()) return;
  const auto& first = map.roads.front().plan.front();
  origin_ = {std::round(first.x), std::round(first.y)};
  std::vector<Box2> boxes;
  covers_.reserve(map.roads.size());
  for (const roadquery::Road& road : map.roads) {
    covers_.emplace_back(road, origin_, 0.0, road.length);
    boxes.push_back(covers_.back().bounds());
  }
  road_index_ = SpatialIndex(boxes);
  boxes.clear();
  for (const roadquery::Junction& junction : map.junctions) {
    const roadquery::JunctionSurface* surface = roadquery::surface_of(junction);
    if (!surface) continue;
    surfaces_.push_back(surface);
    Ring ring;
    for (const auto& [x, y] : surface->boundary) ring.push_back(Vec2{x, y} - origin_);
    boxes.push_back(bounds_of(ring));
  }
  surface_index_ = SpatialIndex(boxes);
}

bool RoadsOver::is_covered(const roadquery::SurfacePoint& p, std::size_t own_road, bool connecting) const {
  const Vec2 at = Vec2{p.x, p.y} - origin_;
  return std::ranges::any_of(road_index_.near(at, 0.0), [&](std::uint32_t i) {
    if (i == own_road || (map_.roads[i].junction >= 0) != connecting) return false;
    if (own_road < map_.roads.size() && goes_on_into(map_.roads[own_road], map_.roads[i])) return false;
    const auto place = covers_[i].find(at, false);
    return place && roadquery::is_same_level(covers_[i].height(*place), p.z);
  });
}

bool RoadsOver::is_carriageway(const roadquery::SurfacePoint& p, std::size_t own_road) const {
  return is_covered(p, own_road, false);
}

bool RoadsOver::is_junction(const roadquery::SurfacePoint& p) const {
  if (is_covered(p, map_.roads.size(), true)) return true;
  return std::ranges::any_of(surface_index_.near(Vec2{p.x, p.y} - origin_, 0.0), [&](std::uint32_t i) {
    const roadquery::JunctionSurface& surface = *surfaces_[i];
    return roadquery::contains(surface, p.x, p.y) &&
           roadquery::is_same_level(roadquery::evaluate(surface, p.x, p.y).z, p.z);
  });
}

}  // namespace orthodrive::network
