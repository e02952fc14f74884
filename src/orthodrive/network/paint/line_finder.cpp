// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/line_finder.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double off_line_m = 4.0;  // roads give way to each other and turn into side roads by less
constexpr double aligned = 0.87;    // cosine: a road that runs 30 degrees off is another one
constexpr double part_m = 8.0;

}  // namespace

LineFinder::LineFinder(const roadquery::RoadMap& map) : map_(map) {
  std::vector<Box2> boxes;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const roadquery::Road& road = map.roads[i];
    const int count = std::max(1, static_cast<int>(std::ceil(road.length / part_m)));
    for (int k = 0; k < count; ++k) {
      const double s = road.length * (k + 0.5) / count, half = 0.5 * road.length / count;
      const auto q = roadquery::reference_point(road, s);
      parts_.push_back({i, s});
      boxes.push_back({q.x - half, q.y - half, q.x + half, q.y + half});
    }
  }
  index_ = SpatialIndex(boxes);
}

std::optional<RoadFoot> LineFinder::find(Vec2 p, Vec2 direction,
                                         const std::function<bool(const roadquery::Road&)>& accept) const {
  std::optional<RoadFoot> best;
  for (const std::uint32_t i : index_.near(p, off_line_m)) {
    const roadquery::Road& road = map_.roads[parts_[i].road];
    if (!accept(road)) continue;
    double s = parts_[i].s;
    roadquery::PlanPoint q;
    for (int step = 0; step < 4; ++step) {
      q = roadquery::reference_point(road, s);
      s = std::clamp(s + (p.x - q.x) * std::cos(q.hdg) + (p.y - q.y) * std::sin(q.hdg), 0.0, road.length);
    }
    q = roadquery::reference_point(road, s);
    const Vec2 along{std::cos(q.hdg), std::sin(q.hdg)}, off = p - Vec2{q.x, q.y};
    constexpr double beyond_m = 0.5;
    if (std::abs(dot(along, direction)) < aligned || std::abs(dot(off, along)) > beyond_m) continue;
    const double t = cross(along, off);
    if (std::abs(t) > off_line_m || (best && std::abs(t) >= std::abs(best->t) - 1e-3)) continue;
    best = RoadFoot{parts_[i].road, s, t};
  }
  return best;
}

Vec2 direction_at(const RoadPath& path, std::size_t node) {
  const std::size_t last = path.nodes.size() - 1;
  return normalized(path.nodes[std::min(node + 1, last)].p - path.nodes[node == 0 ? 0 : node - 1].p);
}

}  // namespace orthodrive::network
