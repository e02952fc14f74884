// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/mrf_surfaces.hpp"

#include <algorithm>
#include <utility>

#include "orthodrive/geo/segment.hpp"
#include "orthodrive/geo/simplify.hpp"

namespace orthodrive::baselines {
namespace {

/// Corners of one side in order, two a rectangle. side: +1 left, -1 right.
Polyline border(std::span<const SegmentRectangle> rectangles, double side) {
  Polyline line;
  for (const SegmentRectangle& r : rectangles) {
    const Vec2 out = r.normal * (0.5 * side * r.width_m);
    line.push_back(r.a + out), line.push_back(r.b + out);
  }
  return line;
}

/// Every point of the border moved onto the simplified one.
Polyline simplified_border(std::span<const SegmentRectangle> rectangles, double side, double tolerance_m) {
  Polyline line = border(rectangles, side);
  const std::vector<bool> stays = simplify(line, tolerance_m);
  for (std::size_t first = 0, i = 1; i < line.size(); ++i) {
    if (!stays[i]) continue;
    for (std::size_t k = first + 1; k < i; ++k) line[k] = nearest_on_segment(line[first], line[i], line[k]);
    first = i;
  }
  return line;
}

/// Rectangles that end and begin at node i of count + 1; the same one twice at the ends of an open road.
std::pair<std::size_t, std::size_t> around_node(std::size_t i, std::size_t count, bool closed) {
  const std::size_t before = i > 0 ? i - 1 : closed ? count - 1 : 0, behind = i < count ? i : closed ? 0 : count - 1;
  return {before, behind};
}

}  // namespace

NodeSurface smooth_surface(std::span<const SegmentRectangle> rectangles, bool closed) {
  NodeSurface surface;
  const std::size_t count = rectangles.size();
  for (std::size_t i = 0; count > 0 && i <= count; ++i) {
    const auto [before, behind] = around_node(i, count, closed);
    const bool at_front = i == 0 && !closed, at_back = i == count && !closed;
    const SegmentRectangle &in = rectangles[before], &out = rectangles[behind];
    const Vec2 end = at_front ? in.a : in.b, begin = at_back ? out.b : out.a;
    // Corners by the mean orientation: the borders of the node are half a width along the bisector from the mean place,
    // which is how RoadNetwork's surface is drawn.
    surface.line.push_back((end + begin) * 0.5);
    surface.width_m.push_back(0.5 * (in.width_m + out.width_m));
  }
  return surface;
}

Ring simplified_outline(std::span<const SegmentRectangle> rectangles, double tolerance_m) {
  Ring ring;
  const Polyline right = border(rectangles, -1.0), left = border(rectangles, 1.0);
  const std::vector<bool> right_stays = simplify(right, tolerance_m), left_stays = simplify(left, tolerance_m);
  for (std::size_t i = 0; i < right.size(); ++i)
    if (right_stays[i]) ring.push_back(right[i]);
  for (std::size_t i = left.size(); i-- > 0;)
    if (left_stays[i]) ring.push_back(left[i]);
  return ring;
}

NodeSurface simplified_surface(std::span<const SegmentRectangle> rectangles, bool closed, double tolerance_m) {
  NodeSurface surface;
  const std::size_t count = rectangles.size();
  const Polyline left = simplified_border(rectangles, 1.0, tolerance_m),
                 right = simplified_border(rectangles, -1.0, tolerance_m);
  for (std::size_t i = 0; count > 0 && i <= count; ++i) {
    const auto [before, behind] = around_node(i, count, closed);
    const std::size_t end = i == 0 && !closed ? 0 : 2 * before + 1,
                      begin = i == count && !closed ? 2 * count - 1 : 2 * behind;
    const Vec2 l = (left[end] + left[begin]) * 0.5, r = (right[end] + right[begin]) * 0.5;
    surface.line.push_back((l + r) * 0.5);
    surface.width_m.push_back(distance(l, r));
  }
  return surface;
}

}  // namespace orthodrive::baselines
