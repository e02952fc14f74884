#include "orthodrive/scene/gravel_areas.hpp"

#include <algorithm>
#include <span>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/drape.hpp"
#include "orthodrive/scene/plan_grid.hpp"
#include "orthodrive/scene/tile_materials.hpp"
#include "orthodrive/scene/triangulate.hpp"

namespace orthodrive::scene {
namespace {

constexpr double lift_m = 0.01, photo_m = 2.0;  // square of the photo that tints a vertex

/// Without crossings of itself, relative to a place of its own: the same for every tile.
MultiPolygon cleaned(const Polygon& polygon, Vec2 from) {
  const Polygon local = moved(polygon, from * -1.0);
  return union_of(std::span(&local, 1), plan_grid_m);
}

/// As polygons of three different corners.
void add_triangles(const Polygon& polygon, Vec2 shift, std::vector<std::array<Vec2, 4>>& triangles) {
  std::vector<Vec2> points;
  std::vector<std::array<std::uint32_t, 2>> constraints;
  const auto add_ring = [&](const Ring& ring) {
    const auto first = static_cast<std::uint32_t>(points.size()), count = static_cast<std::uint32_t>(ring.size());
    points.insert(points.end(), ring.begin(), ring.end());
    for (std::uint32_t i = 0; i < count; ++i) constraints.push_back({first + i, first + (i + 1) % count});
  };
  add_ring(polygon.outer);
  for (const Ring& hole : polygon.holes) add_ring(hole);
  // Rings may touch in a point, which then has one number.
  std::vector<std::uint32_t> order(points.size()), number(points.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto key = [&](std::uint32_t i) { return std::pair(points[i].x, points[i].y); };
  std::ranges::sort(order, {}, key);
  std::vector<Vec2> once;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key(order[i]) != key(order[i - 1])) once.push_back(points[order[i]]);
    number[order[i]] = static_cast<std::uint32_t>(once.size() - 1);
  }
  for (auto& constraint : constraints)
    for (std::uint32_t& end : constraint) end = number[end];
  const Triangulation t = triangulate(once, constraints);
  std::vector<bool> inside;
  for (const Vec2 p : t.region_points) inside.push_back(contains(polygon, p));
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (!inside[t.regions[i]]) continue;
    const auto corner = [&](std::size_t k) { return t.points[t.triangles[i][k]] + shift; };
    triangles.push_back({corner(0), corner(1), corner(2), corner(2)});
  }
}

}  // namespace

void add_gravel(const SceneLayout& layout, const TriMesh& terrain, Vec2 center, TriMesh& gravel) {
  if (!layout.window.surroundings) return;
  const double half_m = 0.5 * scene_tile_m;
  const Box2 tile{center.x - half_m, center.y - half_m, center.x + half_m, center.y + half_m};
  std::vector<std::array<Vec2, 4>> triangles;
  for (const Polygon& polygon : layout.window.surroundings->gravel) {
    const Box2 box = bounds_of(polygon.outer);
    if (!box.overlaps(tile)) continue;
    const Vec2 from = snap_to_grid({0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)});
    for (const Polygon& part : cleaned(polygon, from)) add_triangles(part, from - center, triangles);
  }
  drape(terrain, 0, triangles, lift_m, gravel);
  for (const auto& p : gravel.positions)
    gravel.colors.push_back(mesh_color(photo_mean(*layout.photo, center + Vec2{p[0], p[1]}, photo_m)));
  add_material(SurfaceMaterial::gravel, gravel);
}

}  // namespace orthodrive::scene
