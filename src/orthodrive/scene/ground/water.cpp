// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/water.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr double min_water_m2 = 20.0, shore_reach_m = 2.0;
constexpr double on_shore_m = 2.0 * plan_grid_m;
constexpr double water_cell_m = 128.0;  // of roads that are taken out of water

MultiPolygon moved_all(const MultiPolygon& polygons, Vec2 by) {
  MultiPolygon result;
  for (const Polygon& polygon : polygons) result.push_back(moved(polygon, by));
  return result;
}

/// `shores`, relative to `from`, less what roads take, where they are needed. In cells, so that a river through a town
/// meets few roads at a time.
MultiPolygon beside_roads(const MultiPolygon& shores, const WaterInput& input, Vec2 from) {
  if (shores.empty()) return {};
  const Box2 box = bounds_of_all(shores);
  const Box2 needed{input.box.min_x - from.x, input.box.min_y - from.y, input.box.max_x - from.x,
                    input.box.max_y - from.y};
  MultiPolygon parts;
  for (double x = std::floor(box.min_x / water_cell_m) * water_cell_m; x < box.max_x; x += water_cell_m) {
    for (double y = std::floor(box.min_y / water_cell_m) * water_cell_m; y < box.max_y; y += water_cell_m) {
      const Box2 cell{x, y, x + water_cell_m, y + water_cell_m};
      if (!cell.overlaps(needed)) continue;
      MultiPolygon inside = intersection_of(shores, {polygon_of(cell)}, plan_grid_m);
      if (inside.empty()) continue;
      const Box2 near = bounds_of_all(inside).grown(input.shore_m);
      const MultiPolygon paved = input.roads.paved_near(
          {near.min_x + from.x, near.min_y + from.y, near.max_x + from.x, near.max_y + from.y}, from);
      if (!paved.empty())
        inside = difference_of(inside, buffer_of(union_of(paved, plan_grid_m), input.shore_m, 4), plan_grid_m);
      std::ranges::move(inside, std::back_inserter(parts));
    }
  }
  return parts.empty() ? MultiPolygon{} : union_of(parts, plan_grid_m);
}

/// What is left of the polygon beside roads and the water before it.
MultiPolygon shores_of(const Polygon& polygon, const WaterInput& input, const std::vector<WaterBody>& before) {
  const Box2 box = bounds_of(polygon.outer);
  const Vec2 from = snap_to_grid({0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)});
  const Polygon local = moved(polygon, from * -1.0);
  MultiPolygon shores = union_of(std::span(&local, 1), plan_grid_m);
  shores = intersection_of(shores, {moved(input.area, from * -1.0)}, plan_grid_m);
  shores = beside_roads(shores, input, from);
  for (const WaterBody& other : before)
    if (!shores.empty() && other.box.min_x <= box.max_x && other.box.max_x >= box.min_x &&
        other.box.min_y <= box.max_y && other.box.max_y >= box.min_y)
      shores = difference_of(shores, moved_all(other.shores, from * -1.0), plan_grid_m);
  std::erase_if(shores, [](const Polygon& part) { return area_m2(part) < min_water_m2; });
  return moved_all(shores, from);
}

}  // namespace

Waters::Waters(const MultiPolygon& polygons, std::span<const std::optional<WaterLevel>> levels,
               const WaterInput& input) {
  std::vector<Box2> boxes;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    const std::optional<WaterLevel>& level = levels[i];
    if (!level) continue;
    MultiPolygon shores = shores_of(polygons[i], input, bodies_);
    if (shores.empty()) continue;
    const Box2 box = bounds_of_all(shores);
    boxes.push_back(box.grown(shore_reach_m));
    Outline outline(shores, shore_reach_m);
    bodies_.push_back({std::move(shores), box, std::move(outline), level->level_m, level->color});
  }
  index_ = SpatialIndex(boxes);
}

const WaterBody* Waters::at(Vec2 p) const {
  for (const std::uint32_t i : index_.near(p, 0.0)) {
    const WaterBody& body = bodies_[i];
    if (body.outline.nearest(p).distance_m <= on_shore_m || body.outline.contains(p)) return &body;
  }
  return nullptr;
}

double Waters::shore_distance_m(Vec2 p) const {
  double nearest = shore_reach_m;
  for (const std::uint32_t i : index_.near(p, 0.0))
    nearest = std::min(nearest, bodies_[i].outline.nearest(p).distance_m);
  return nearest;
}

}  // namespace orthodrive::scene
