// SPDX-License-Identifier: Apache-2.0
#pragma once
// A point and a segment from a to b.

#include <algorithm>

#include "orthodrive/geo/vec.hpp"

namespace orthodrive {

/// How far along the segment its point nearest to p lies, 0 to 1; 0 where a and b are one.
[[nodiscard]] inline double share_along(Vec2 a, Vec2 b, Vec2 p) {
  const Vec2 d = b - a;
  const double squared = dot(d, d);
  return squared > 0.0 ? std::clamp(dot(p - a, d) / squared, 0.0, 1.0) : 0.0;
}

[[nodiscard]] inline Vec2 nearest_on_segment(Vec2 a, Vec2 b, Vec2 p) { return a + (b - a) * share_along(a, b, p); }

[[nodiscard]] inline double distance_to_segment(Vec2 a, Vec2 b, Vec2 p) {
  return distance(p, nearest_on_segment(a, b, p));
}

[[nodiscard]] inline Box2 segment_box(Vec2 a, Vec2 b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::max(a.x, b.x), std::max(a.y, b.y)};
}

}  // namespace orthodrive
