// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/path_crossings.hpp"

#include <optional>
#include <utility>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {
namespace {

bool share_node(const RoadNode& a0, const RoadNode& a1, const RoadNode& b0, const RoadNode& b1) {
  const auto is_end_of_b = [&](const RoadNode& a) {
    return is_osm_node(a.osm_node) && (a.osm_node == b0.osm_node || a.osm_node == b1.osm_node);
  };
  return is_end_of_b(a0) || is_end_of_b(a1);
}

/// Fractions along both segments; none for parallel segments and for those that do not reach each other.
std::optional<std::pair<double, double>> intersect(Vec2 a0, Vec2 a1, Vec2 b0, Vec2 b1) {
  const Vec2 a = a1 - a0, b = b1 - b0;
  const double det = cross(a, b);
  if (det == 0.0) return std::nullopt;
  const double fa = cross(b0 - a0, b) / det, fb = cross(b0 - a0, a) / det;
  // Half open, so that a crossing exactly at a node between two segments counts once.
  if (fa < 0.0 || fa >= 1.0 || fb < 0.0 || fb >= 1.0) return std::nullopt;
  return std::pair{fa, fb};
}

}  // namespace

std::vector<PathCrossing> find_crossings(const RoadNetwork& roads) {
  std::vector<Polyline> lines;
  lines.reserve(roads.paths.size());
  for (const RoadPath& path : roads.paths) lines.push_back(centerline(path));
  const SegmentIndex index(lines);
  std::vector<PathCrossing> crossings;
  for (std::size_t p = 0; p < roads.paths.size(); ++p) {
    const auto& na = roads.paths[p].nodes;
    for (std::size_t i = 0; i + 1 < na.size(); ++i) {
      const RoadNode &a0 = na[i], &a1 = na[i + 1];
      for (const auto [other, k] : index.touching(bounds_of({a0.p, a1.p}))) {
        if (other < p || (other == p && k <= i + 1)) continue;  // neighbours meet, they do not cross
        const RoadNode &b0 = roads.paths[other].nodes[k], &b1 = roads.paths[other].nodes[k + 1];
        const auto fractions = intersect(a0.p, a1.p, b0.p, b1.p);
        if (!fractions || share_node(a0, a1, b0, b1)) continue;
        crossings.push_back(
            {p, other, i, k, fractions->first, fractions->second, a0.p + (a1.p - a0.p) * fractions->first});
      }
    }
  }
  return crossings;
}

}  // namespace orthodrive
