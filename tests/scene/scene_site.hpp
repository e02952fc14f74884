// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small sites with exact truth for the tests of the scene, and what must hold for every mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/build_scene.hpp"
#include "orthodrive/scene/structures/structures.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene_test {

constexpr double pi = std::numbers::pi;
constexpr double west_m = 480.0 * 1000, south_m = 480.0 * 13000;  // corner of a tile, in the range of UTM coordinates

struct RoadShape {
  Vec2 start;
  double heading_rad = 0.0, length_m = 100.0, width_m = 6.0, z_m = 10.0, gradient = 0.0;
  double curvature_1pm = 0.0, superelevation_rad = 0.0;
  int layer = 0;
  bool bridge = false, tunnel = false;
};

inline roadquery::Road make_road(int id, const RoadShape& shape) {
  roadquery::Road road;
  road.id = id;
  road.length = shape.length_m;
  roadquery::PlanElement element{
      .x = shape.start.x, .y = shape.start.y, .hdg = shape.heading_rad, .length = shape.length_m};
  if (shape.curvature_1pm != 0.0) element.shape = roadquery::Arc{shape.curvature_1pm};
  road.plan = {element};
  road.elevation = {{.a = shape.z_m, .b = shape.gradient}};
  road.superelevation = {{.a = shape.superelevation_rad}};
  roadquery::LaneSection section;
  section.left = {{.id = 1, .width = {{.a = 0.5 * shape.width_m}}}};
  section.right = {{.id = -1, .width = {{.a = 0.5 * shape.width_m}}}};
  road.sections = {section};
  road.layer = shape.layer, road.bridge = shape.bridge, road.tunnel = shape.tunnel;
  return road;
}

/// Ground from (west, south) on, `size_m` a side, with a photo of 1 m and a terrain model of 5 m.
struct Site {
  roadquery::RoadMap roads;
  HeightGrid terrain;
  Photo photo;
  Polygon area;

  [[nodiscard]] SceneInput input() const { return {roads, terrain, photo, area}; }
};

inline Ring square(double x, double y, double size_m) {
  return {{x, y}, {x + size_m, y}, {x + size_m, y + size_m}, {x, y + size_m}};
}

inline Site make_site(
    double size_m, const std::vector<RoadShape>& roads,
    const std::function<double(Vec2)>& height_m = [](Vec2) { return 10.0; }) {
  Site site;
  for (std::size_t i = 0; i < roads.size(); ++i)
    site.roads.roads.push_back(make_road(static_cast<int>(i) + 1, roads[i]));
  const Box2 box{west_m, south_m, west_m + size_m, south_m + size_m};
  site.terrain.frame = covering_grid(box.grown(20.0), 5.0);
  site.terrain.height_m = Raster<float>(site.terrain.frame.width, site.terrain.frame.height);
  for (int row = 0; row < site.terrain.frame.height; ++row)
    for (int col = 0; col < site.terrain.frame.width; ++col)
      site.terrain.height_m.at(col, row) = static_cast<float>(height_m(site.terrain.frame.center_of(col, row)));
  site.photo.frame = covering_grid(box, 1.0);
  site.photo.rgb = Raster<std::uint8_t>(site.photo.frame.width, site.photo.frame.height, 3, 90);
  site.photo.valid = Raster<std::uint8_t>(site.photo.frame.width, site.photo.frame.height, 1, 1);
  site.area.outer = square(west_m, south_m, size_m);
  return site;
}

inline const TriMesh* find_mesh(const SceneTile& tile, MeshKind kind) {
  for (const TriMesh& mesh : tile.meshes)
    if (mesh.kind == kind) return &mesh;
  return nullptr;
}

inline Vec3 world(const SceneTile& tile, const std::array<float, 3>& p) { return tile.origin + Vec3{p[0], p[1], p[2]}; }

/// Height of the mesh at p; NaN where it has no triangle.
inline double mesh_height_m(const SceneTile& tile, const TriMesh& mesh, Vec2 p) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vec3 a = world(tile, mesh.positions[mesh.indices[i]]), b = world(tile, mesh.positions[mesh.indices[i + 1]]),
               c = world(tile, mesh.positions[mesh.indices[i + 2]]);
    const Vec2 ab{b.x - a.x, b.y - a.y}, ac{c.x - a.x, c.y - a.y}, ap{p.x - a.x, p.y - a.y};
    const double u = cross(ap, ac) / cross(ab, ac), v = cross(ab, ap) / cross(ab, ac);
    if (u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9) return a.z + u * (b.z - a.z) + v * (c.z - a.z);
  }
  return std::nan("");
}

inline double plan_area_m2(const TriMesh* mesh) {
  if (mesh == nullptr) return 0.0;
  double twice = 0.0;
  for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
    const auto &a = mesh->positions[mesh->indices[i]], &b = mesh->positions[mesh->indices[i + 1]],
               &c = mesh->positions[mesh->indices[i + 2]];
    const Vec2 ab{double{b[0]} - a[0], double{b[1]} - a[1]}, ac{double{c[0]} - a[0], double{c[1]} - a[1]};
    twice += cross(ab, ac);
  }
  return 0.5 * twice;
}

/// Every triangle counter-clockwise from above and not empty.
inline void expect_upwards(const TriMesh& mesh) {
  int wrong = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto &a = mesh.positions[mesh.indices[i]], &b = mesh.positions[mesh.indices[i + 1]],
               &c = mesh.positions[mesh.indices[i + 2]];
    const Vec2 ab{double{b[0]} - a[0], double{b[1]} - a[1]}, ac{double{c[0]} - a[0], double{c[1]} - a[1]};
    wrong += cross(ab, ac) > 0.0 ? 0 : 1;
  }
  EXPECT_EQ(wrong, 0) << to_string(mesh.kind);
}

/// Terrain, water and road together are a surface without cracks: each edge inside is used once in each direction, by
/// positions (heights included); edges used once only lie on the tile's or the area's border.
inline void expect_closed(const SceneTile& tile, const std::function<bool(Vec2, Vec2)>& may_be_open) {
  using Point = std::array<float, 3>;
  std::map<Point, std::uint32_t> number_of;  // of a position, in whichever mesh
  std::vector<Point> positions;
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const MeshKind kind : {MeshKind::terrain, MeshKind::water, MeshKind::road}) {
    const TriMesh* mesh = find_mesh(tile, kind);
    if (mesh == nullptr) continue;
    std::vector<std::uint32_t> numbers;
    for (const Point& position : mesh->positions) {
      const auto [at, is_new] = number_of.try_emplace(position, static_cast<std::uint32_t>(positions.size()));
      if (is_new) positions.push_back(position);
      numbers.push_back(at->second);
    }
    for (std::size_t i = 0; i < mesh->indices.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k)
        edges.push_back({numbers[mesh->indices[i + k]], numbers[mesh->indices[i + (k + 1) % 3]]});
  }
  std::ranges::sort(edges);
  int open = 0, doubled = 0;
  Vec3 where;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (i > 0 && edges[i] == edges[i - 1]) ++doubled;
    const auto [from, to] = edges[i];
    if (std::ranges::binary_search(edges, std::array{to, from})) continue;
    const Vec3 a = world(tile, positions[from]), b = world(tile, positions[to]);
    if (may_be_open({a.x, a.y}, {b.x, b.y})) continue;
    ++open, where = a;
  }
  EXPECT_EQ(doubled, 0);
  EXPECT_EQ(open, 0) << "an open edge starts at " << where.x << ' ' << where.y << ' ' << where.z;
}

inline bool on_tile_border(Vec2 a, Vec2 b) {
  const auto on = [](double u, double v) { return u == v && std::fmod(u, scene_tile_m) == 0.0; };
  return on(a.x, b.x) || on(a.y, b.y);
}

/// Area that the faces' triangles share with the polygons in plan.
inline double shared_m2(const std::map<TileAddress, std::vector<scene::StructureFace>>& tiles,
                        const MultiPolygon& polygons) {
  const Vec2 from{west_m, south_m};
  MultiPolygon taken;
  for (const Polygon& polygon : polygons) taken.push_back(moved(polygon, from * -1.0));
  std::vector<Polygon> covered;
  for (const auto& [address, faces] : tiles)
    for (const scene::StructureFace& face : faces) {
      std::vector<Vec2> corners;
      corners.reserve(std::size(face.corners));
      for (const Vec3& c : face.corners) corners.push_back(Vec2{c.x, c.y} - from);
      Ring ring = convex_hull(std::move(corners));
      if (ring.size() >= 3 && signed_area_m2(ring) > 1e-6) covered.push_back({std::move(ring), {}});
    }
  if (covered.empty()) return 0.0;
  double sum = 0.0;
  for (const Polygon& part : intersection_of(union_of(covered, 1e-3), union_of(taken, 1e-3), 1e-3))
    sum += area_m2(part);
  return sum;
}

}  // namespace orthodrive::scene_test
