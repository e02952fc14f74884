// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/scene_windows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

/// Grows to hold points.
struct WindowExtent {
  Box2 box{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           -std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  void add(Vec2 p) {
    box = {std::min(box.min_x, p.x), std::min(box.min_y, p.y), std::max(box.max_x, p.x), std::max(box.max_y, p.y)};
  }
};

/// Of all that the road covers: its edges every 10 m, and twice the half width of what may bulge out between.
Box2 box_of(const roadquery::Road& road) {
  constexpr double step_m = 10.0, most_steps = 1e5;
  WindowExtent extent;
  double widest_m = 0.0;
  const double steps = std::clamp(std::ceil(road.length / step_m), 1.0, most_steps);
  for (int k = 0; k <= static_cast<int>(steps); ++k) {
    const double s = road.length * k / steps;
    const roadquery::PlanPoint at = roadquery::reference_point(road, s);
    extent.add({at.x, at.y});
    if (road.sections.empty()) continue;
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    widest_m = std::max({widest_m, std::abs(edges.left_t), std::abs(edges.right_t)});
  }
  return extent.box.grown(widest_m + step_m);
}

Box2 box_of(const roadquery::Junction& junction) {
  WindowExtent extent;
  if (junction.surface)
    for (const auto& [x, y] : junction.surface->boundary) extent.add({x, y});
  return extent.box;
}

template <typename Points>
bool reaches(const Points& points, const Box2& box) {
  WindowExtent extent;
  for (const Vec2 p : points) extent.add(p);
  return extent.box.overlaps(box);
}

}  // namespace

SceneWindows::SceneWindows(const SceneSource& source, const SceneFrame& frame) : source_(&source), frame_(&frame) {
  std::vector<Box2> boxes;
  boxes.reserve(source.roads.roads.size());
  for (const roadquery::Road& road : source.roads.roads) boxes.push_back(box_of(road));
  roads_ = SpatialIndex(boxes);
  boxes.clear();
  for (const roadquery::Junction& junction : source.roads.junctions) boxes.push_back(box_of(junction));
  junctions_ = SpatialIndex(boxes);
}

roadquery::RoadMap SceneWindows::roads_in(const Box2& box) const {
  const roadquery::RoadMap& all = source_->roads;
  std::vector<bool> wanted(all.roads.size(), false);
  std::set<int> junctions;
  for (const std::uint32_t i : junctions_.touching(box)) junctions.insert(all.junctions[i].id);
  for (const std::uint32_t i : roads_.touching(box)) {
    wanted[i] = true;
    if (all.roads[i].junction >= 0) junctions.insert(all.roads[i].junction);
  }
  roadquery::RoadMap part;
  part.geo_reference = all.geo_reference;
  for (std::size_t i = 0; i < all.roads.size(); ++i)
    if (wanted[i] || junctions.contains(all.roads[i].junction)) part.roads.push_back(all.roads[i]);
  for (const roadquery::Junction& junction : all.junctions)
    if (junctions.contains(junction.id)) part.junctions.push_back(junction);
  return part;
}

SceneWindow SceneWindows::window(const Box2& box) const {
  SceneWindow window{.box = box, .roads = roads_in(box)};
  window.terrain = frame_->terrain->window(box);
  window.photo = window_of(frame_->photo, box);
  if (source_->labels) window.labels = window_of(*source_->labels, box);
  for (const Building& building : source_->buildings)
    if (reaches(building.footprint.outer, box)) window.buildings.push_back(building);
  for (const Vec2 tree : source_->trees)
    if (box.contains(tree)) window.trees.push_back(tree);
  if (source_->surroundings == nullptr) return window;
  const MapSurroundings& all = *source_->surroundings;
  MapSurroundings& near = window.surroundings.emplace();
  for (const MapBarrier& barrier : all.barriers)
    if (reaches(barrier.line, box)) near.barriers.push_back(barrier);
  for (std::size_t i = 0; i < all.water.size(); ++i) {
    if (!reaches(all.water[i].outer, box)) continue;
    near.water.push_back(all.water[i]);
    window.water_levels.push_back(frame_->water_levels[i]);
  }
  for (const Polygon& gravel : all.gravel)
    if (reaches(gravel.outer, box)) near.gravel.push_back(gravel);
  for (const Polygon& area : all.parking)
    if (reaches(area.outer, box)) near.parking.push_back(area);
  for (const MapPath& path : all.paths)
    if (reaches(path.line, box)) near.paths.push_back(path);
  for (const Polyline& track : all.tracks)
    if (reaches(track, box)) near.tracks.push_back(track);
  for (const Vec2 lamp : all.lamps)
    if (box.contains(lamp)) near.lamps.push_back(lamp);
  for (const MapObject& object : all.objects)
    if (box.contains(object.at)) near.objects.push_back(object);
  for (std::size_t i = 0; i < all.power_lines.size(); ++i) {
    if (!reaches(all.power_lines[i].line, box)) continue;
    near.power_lines.push_back(all.power_lines[i]);
    window.power_ground_m.push_back(frame_->power_ground_m[i]);
  }
  return window;
}

}  // namespace orthodrive::scene
