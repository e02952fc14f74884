// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/polygon.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {
/// Even-odd rule, half-open in y so that a ray through a vertex counts once.
bool crosses_odd(const Ring& ring, Vec2 p) {
  bool inside = false;
  for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
    const Vec2 a = ring[i], b = ring[j];
    if ((a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x) inside = !inside;
  }
  return inside;
}
}  // namespace

double signed_area_m2(const Ring& ring) {
  if (ring.size() < 3) return 0.0;
  double twice = 0.0;  // relative to the first point, or UTM northings eat the digits
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) twice += cross(ring[i] - ring[0], ring[i + 1] - ring[0]);
  return 0.5 * twice;
}

double area_m2(const Polygon& polygon) {
  double area = std::abs(signed_area_m2(polygon.outer));
  for (const Ring& hole : polygon.holes) area -= std::abs(signed_area_m2(hole));
  return area;
}

Polygon moved(Polygon polygon, Vec2 by) {
  for (Vec2& p : polygon.outer) p = p + by;
  for (Ring& hole : polygon.holes)
    for (Vec2& p : hole) p = p + by;
  return polygon;
}

bool contains(const Polygon& polygon, Vec2 p) {
  if (polygon.outer.size() < 3) return false;
  bool inside = crosses_odd(polygon.outer, p);
  for (const Ring& hole : polygon.holes)
    if (hole.size() >= 3 && crosses_odd(hole, p)) inside = !inside;
  return inside;
}

bool contains(const MultiPolygon& polygons, Vec2 p) {
  return std::any_of(polygons.begin(), polygons.end(), [&](const Polygon& polygon) { return contains(polygon, p); });
}

Box2 bounds_of(const Ring& ring) {
  if (ring.empty()) return {};
  Box2 box{ring[0].x, ring[0].y, ring[0].x, ring[0].y};
  for (const Vec2 p : ring)
    box = {std::min(box.min_x, p.x), std::min(box.min_y, p.y), std::max(box.max_x, p.x), std::max(box.max_y, p.y)};
  return box;
}

Polygon polygon_of(const Box2& box) {
  return {{{box.min_x, box.min_y}, {box.max_x, box.min_y}, {box.max_x, box.max_y}, {box.min_x, box.max_y}}, {}};
}

Box2 bounds_of_all(const MultiPolygon& polygons) {
  Box2 box = bounds_of(polygons.front().outer);
  for (const Polygon& part : polygons) {
    const Box2 own = bounds_of(part.outer);
    box = {std::min(box.min_x, own.min_x), std::min(box.min_y, own.min_y), std::max(box.max_x, own.max_x),
           std::max(box.max_y, own.max_y)};
  }
  return box;
}

void rasterize(const Polygon& polygon, const GridFrame& frame, const std::function<void(int, int, int)>& span) {
  struct Edge {
    double x0, y0, x1, y1;  // pixel coordinates, y0 < y1
  };
  GridFrame grid = frame;  // edges are those of the whole grid, or rounding would differ from window to window
  grid.first_col = grid.first_row = 0;
  std::vector<Edge> edges;
  auto add = [&](const Ring& ring) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      Vec2 a = grid.pixel_from_world(ring[j]), b = grid.pixel_from_world(ring[i]);
      if (a.y == b.y) continue;
      if (a.y > b.y) std::swap(a, b);
      edges.push_back({a.x, a.y, b.x, b.y});
    }
  };
  if (polygon.outer.size() < 3) return;
  add(polygon.outer);
  for (const Ring& hole : polygon.holes)
    if (hole.size() >= 3) add(hole);
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.y0 < b.y0; });
  if (edges.empty()) return;

  double bottom = edges[0].y1;
  for (const Edge& edge : edges) bottom = std::max(bottom, edge.y1);
  const int first = std::max(frame.first_row, static_cast<int>(std::ceil(edges[0].y0 - 0.5)));
  const int end = std::min(frame.first_row + frame.height, static_cast<int>(std::ceil(bottom - 0.5)));
  std::vector<Edge> active;
  std::vector<double> crossings;
  std::size_t next = 0;
  for (int row = first; row < end; ++row) {
    const double y = row + 0.5;
    while (next < edges.size() && edges[next].y0 <= y) active.push_back(edges[next++]);
    std::erase_if(active, [y](const Edge& edge) { return edge.y1 <= y; });
    crossings.clear();
    for (const Edge& e : active) crossings.push_back(e.x0 + (y - e.y0) * (e.x1 - e.x0) / (e.y1 - e.y0));
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const auto width = static_cast<double>(frame.width);
      const double lo = std::clamp(std::ceil(crossings[i] - 0.5) - frame.first_col, 0.0, width);
      const double hi = std::clamp(std::ceil(crossings[i + 1] - 0.5) - frame.first_col, 0.0, width);
      if (lo < hi) span(row - frame.first_row, static_cast<int>(lo), static_cast<int>(hi));
    }
  }
}

Ring convex_hull(std::vector<Vec2> points) {  // Andrew's monotone chain
  if (points.size() < 3) return points;
  std::sort(points.begin(), points.end(), [](Vec2 a, Vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  Ring hull;
  for (int side = 0; side < 2; ++side) {  // the lower, then the upper one
    const std::size_t first = hull.size();
    for (const Vec2 p : points) {
      while (hull.size() >= first + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0)
        hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();  // the first of the other side
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

}  // namespace orthodrive
