// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/roads/roads_across.hpp"

#include <cmath>

namespace orthodrive::evaluate {
namespace {

std::vector<Polyline> centerlines(const RoadNetwork& roads) {
  std::vector<Polyline> lines;
  lines.reserve(roads.paths.size());
  for (const RoadPath& path : roads.paths) lines.push_back(centerline(path));
  return lines;
}

}  // namespace

RoadsAcross::RoadsAcross(const RoadNetwork& roads) : roads_(roads), index_(centerlines(roads)) {}

std::optional<Across> RoadsAcross::find(const Query& query) const {
  const Vec2 left = left_normal(query.direction);
  const double min_cos = std::cos(query.max_angle_rad);
  std::optional<Across> nearest;
  for (const auto [line, i] :
       index_.touching(bounds_of({query.p - query.reach_m * left, query.p + query.reach_m * left}))) {
    const RoadPath& path = roads_.paths[line];
    if (query.layer && path.layer != *query.layer) continue;
    const Vec2 a = path.nodes[i].p, d = path.nodes[i + 1].p - a;
    const double along = dot(d, query.direction), size = length(d);
    if (size == 0.0 || std::abs(along) < min_cos * size) continue;
    // p + t left = a + u d, by the component along the direction.
    const double u = dot(query.p - a, query.direction) / along;
    if (u < 0.0 || u > 1.0) continue;
    const double t = dot(a + u * d - query.p, left);
    // Of paths that share a node the first one counts.
    if (std::abs(t) <= query.reach_m && (!nearest || std::abs(t) < std::abs(nearest->offset_m)))
      nearest = Across{line, i, u, t, along > 0.0};
  }
  return nearest;
}

}  // namespace orthodrive::evaluate
