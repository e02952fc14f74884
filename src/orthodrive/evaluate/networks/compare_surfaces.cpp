// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/compare_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

constexpr double step_m = 2.0, same_length_m = 1e-3;

void compare_roads(const roadquery::Road& a, const roadquery::Road& b, SurfaceComparison& result) {
  const int steps = std::max(1, static_cast<int>(std::ceil(a.length / step_m)));
  for (int k = 0; k <= steps; ++k) {
    const double s = a.length * k / steps;
    const roadquery::Edges edges = roadquery::road_edges(a, s);
    for (const double t : {edges.left_t, 0.5 * (edges.left_t + edges.right_t), edges.right_t}) {
      const roadquery::SurfacePoint p = roadquery::surface_point(a, s, t), q = roadquery::surface_point(b, s, t);
      const double apart = std::hypot(p.x - q.x, p.y - q.y, p.z - q.z);
      if (apart > result.max_distance_m || result.points == 0)
        result.max_distance_m = apart, result.road = a.id, result.s = s;
      ++result.points;
    }
  }
}

}  // namespace

SurfaceComparison compare_surfaces(const roadquery::RoadMap& a, const roadquery::RoadMap& b) {
  SurfaceComparison result{.max_distance_m = std::numeric_limits<double>::quiet_NaN()};
  std::map<int, const roadquery::Road*> others;
  for (const roadquery::Road& road : b.roads) others.emplace(road.id, &road);
  for (const roadquery::Road& road : a.roads) {
    const auto other = others.find(road.id);
    if (other == others.end()) {
      ++result.missing_roads;
      continue;
    }
    if (std::abs(road.length - other->second->length) > same_length_m)
      ++result.missing_roads;
    else
      compare_roads(road, *other->second, result);
    others.erase(other);
  }
  result.missing_roads += others.size();
  return result;
}

}  // namespace orthodrive
