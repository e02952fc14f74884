// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/narrowest_rectangle.hpp"

#include <algorithm>
#include <limits>

namespace orthodrive {

Ring narrowest_rectangle(const Ring& ring) {
  const Ring hull = convex_hull(ring);
  if (hull.size() < 3) return {};
  Ring best;
  double best_m2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 u = normalized(hull[(i + 1) % hull.size()] - hull[i]), v = left_normal(u);
    Box2 box{dot(hull[0], u), dot(hull[0], v), dot(hull[0], u), dot(hull[0], v)};
    for (const Vec2 p : hull)
      box = {std::min(box.min_x, dot(p, u)), std::min(box.min_y, dot(p, v)), std::max(box.max_x, dot(p, u)),
             std::max(box.max_y, dot(p, v))};
    const double m2 = (box.max_x - box.min_x) * (box.max_y - box.min_y);
    if (!(m2 < best_m2)) continue;
    best_m2 = m2;
    best = {u * box.min_x + v * box.min_y, u * box.max_x + v * box.min_y, u * box.max_x + v * box.max_y,
            u * box.min_x + v * box.max_y};
  }
  return best;
}

}  // namespace orthodrive
