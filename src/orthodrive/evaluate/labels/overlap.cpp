// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/labels/overlap.hpp"

#include "orthodrive/geo/overlay.hpp"

namespace orthodrive::evaluate {
namespace {

constexpr double grid_m = 1e-3;

MultiPolygon moved(MultiPolygon polygons, Vec2 by) {
  for (Polygon& polygon : polygons) polygon = orthodrive::moved(std::move(polygon), by);
  return polygons;
}

double area_sum_m2(const MultiPolygon& polygons) {
  double sum = 0.0;
  for (const Polygon& polygon : polygons) sum += area_m2(polygon);
  return sum;
}

/// Both unions inside the region, relative to `origin`: small numbers keep the digits.
struct Unions {
  Vec2 origin;
  MultiPolygon first, second;
};

Unions unions_in(const std::vector<Polygon>& first, const std::vector<Polygon>& second, const ScoreRegion& region) {
  Vec2 origin;
  for (const auto* set : {&first, &second})
    for (const Polygon& polygon : *set)
      if (!polygon.outer.empty()) origin = polygon.outer.front();
  const auto joined = [&](const std::vector<Polygon>& set) { return union_of(moved(set, origin * -1.0), grid_m); };
  Unions unions{origin, joined(first), joined(second)};
  if (region.area) {
    const MultiPolygon area = joined(*region.area);
    unions.first = intersection_of(unions.first, area, grid_m);
    unions.second = intersection_of(unions.second, area, grid_m);
  }
  if (!region.ignore.empty()) {
    const MultiPolygon ignore = joined(region.ignore);
    unions.first = difference_of(unions.first, ignore, grid_m);
    unions.second = difference_of(unions.second, ignore, grid_m);
  }
  return unions;
}

}  // namespace

OverlapAreas overlap_areas(const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                           const ScoreRegion& region) {
  const Unions unions = unions_in(first, second, region);
  return {area_sum_m2(unions.first), area_sum_m2(unions.second),
          area_sum_m2(intersection_of(unions.first, unions.second, grid_m))};
}

OverlapDifferences overlap_differences(const std::vector<Polygon>& first, const std::vector<Polygon>& second,
                                       const ScoreRegion& region) {
  const Unions unions = unions_in(first, second, region);
  return {moved(difference_of(unions.first, unions.second, grid_m), unions.origin),
          moved(difference_of(unions.second, unions.first, grid_m), unions.origin)};
}

std::vector<Polygon> carriageway_polygons(const RoadPath& path) {
  Ring strip = surface_ring(path);
  if (is_simple(orthodrive::moved(Polygon{strip, {}}, strip.front() * -1.0).outer)) return {{std::move(strip), {}}};
  std::vector<Polygon> cells;
  for (Ring& cell : surface_cells(path)) cells.push_back({std::move(cell), {}});
  return cells;
}

}  // namespace orthodrive::evaluate
