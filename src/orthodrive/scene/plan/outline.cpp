// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plan/outline.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/segment.hpp"

namespace orthodrive::scene {

Outline::Outline(const MultiPolygon& polygons, double reach_m, const std::function<double(Vec2)>& height_m, int threads)
    : reach_m_(reach_m) {
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) segments_.push_back({ring[i], ring[(i + 1) % ring.size()]});
  };
  for (const Polygon& polygon : polygons) {
    add(polygon.outer);
    for (const Ring& hole : polygon.holes) add(hole);
  }
  if (segments_.empty()) return;
  if (height_m) {
    // Each point is evaluated for both of its segments: twice the work, but no bookkeeping of rings.
    parallel_for(segments_.size(), threads, [&](std::size_t i) {
      segments_[i].a_z_m = height_m(segments_[i].a);
      segments_[i].b_z_m = height_m(segments_[i].b);
    });
  }
  std::vector<Box2> boxes;
  boxes.reserve(segments_.size());
  for (const auto& [a, b, az, bz] : segments_) boxes.push_back(bounds_of({a, b}));
  index_ = SpatialIndex(boxes);
}

bool Outline::contains(Vec2 p) const {
  bool inside = false;
  for (const std::uint32_t i : index_.touching({p.x, p.y, std::numeric_limits<double>::infinity(), p.y})) {
    const Vec2 a = segments_[i].a, b = segments_[i].b;
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

NearestBorder Outline::nearest(Vec2 p) const {
  NearestBorder best;
  double best_m2 = reach_m_ * reach_m_;
  for (const std::uint32_t i : index_.near(p, reach_m_)) {
    const auto& [a, b, az, bz] = segments_[i];
    const double u = share_along(a, b, p);
    const Vec2 d = p - (a + (b - a) * u);
    if (dot(d, d) <= best_m2) {
      best_m2 = dot(d, d);
      best = {std::sqrt(best_m2), az + (bz - az) * u};
    }
  }
  return best;
}

}  // namespace orthodrive::scene
