// SPDX-License-Identifier: Apache-2.0
// One tile of the scene: a hill, a grey photo and one road over it, made in place; the meshes with their sizes, and a
// point of the road's mesh against the road's own surface: what is seen is what is driven.
//
// Read first: src/orthodrive/scene/build_scene.hpp, src/orthodrive/model/scene.hpp. Before: 03_refine_one_road.cpp.
// The command that writes such tiles as glTF: `orthodrive scene --help`.

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "orthodrive/scene/build_scene.hpp"
#include "roadquery/query/road_query.hpp"

using namespace orthodrive;

namespace {

constexpr double west = 480.0 * 1000, south = 480.0 * 13000, size_m = 200.0;  // the corner of a tile

roadquery::RoadMap one_road() {
  roadquery::Road road{.id = 1, .length = 160.0};
  road.plan = {{.x = west + 20.0, .y = south + 100.0, .length = 160.0}};  // eastwards
  road.elevation = {{.a = 10.5, .b = 0.02}};                              // 2 % uphill
  road.superelevation = {{.a = 0.03}};                                    // the left side higher
  roadquery::LaneSection section;
  section.left = {{.id = 1, .width = {{.a = 3.5}}}};
  section.right = {{.id = -1, .width = {{.a = 3.5}}}};
  road.sections = {section};
  roadquery::RoadMap map;
  map.roads = {road};
  return map;
}

HeightGrid hill() {
  HeightGrid grid;
  grid.frame = covering_grid({west - 20.0, south - 20.0, west + size_m + 20.0, south + size_m + 20.0}, 5.0);
  grid.height_m = Raster<float>(grid.frame.width, grid.frame.height);
  for (int row = 0; row < grid.frame.height; ++row)
    for (int col = 0; col < grid.frame.width; ++col) {
      const Vec2 p = grid.frame.center_of(col, row) - Vec2{west, south};
      grid.height_m.at(col, row) = static_cast<float>(10.0 + 0.02 * p.x + std::sin(p.y / 30.0));
    }
  return grid;
}

Photo grey_photo() {
  Photo photo;
  photo.frame = covering_grid({west, south, west + size_m, south + size_m}, 1.0);
  photo.rgb = Raster<std::uint8_t>(photo.frame.width, photo.frame.height, 3, 120);
  photo.valid = Raster<std::uint8_t>(photo.frame.width, photo.frame.height, 1, 1);
  return photo;
}

/// Largest difference of a vertex of the road's mesh from the surface that is driven, inside the road.
double largest_difference_m(const TriMesh& mesh, const Vec3& tile_origin, const roadquery::RoadQuery& query) {
  double worst = 0.0;
  roadquery::Cursor cursor;
  for (const auto& p : mesh.positions) {
    const Vec3 at = tile_origin + Vec3{p[0], p[1], p[2]};
    if (const auto hit = query.find(at.x, at.y, at.z, cursor)) worst = std::max(worst, std::abs(hit->z - at.z));
  }
  return worst;
}

}  // namespace

int main() {
  const roadquery::RoadMap roads = one_road();
  const HeightGrid terrain = hill();
  const Photo photo = grey_photo();
  const Polygon area{{{west, south}, {west + size_m, south}, {west + size_m, south + size_m}, {west, south + size_m}},
                     {}};
  const auto layout = lay_out_scene({roads, terrain, photo, area}, {.road_tolerance_m = 0.01});
  const SceneTile tile = build_scene_tile(*layout, scene_tiles(*layout).front());
  std::printf("tile %d, %d with a texture of %d x %d px\n", tile.column, tile.row, tile.texture_rgb.width,
              tile.texture_rgb.height);
  for (const TriMesh& mesh : tile.meshes)
    std::printf("%-10s %6zu vertices, %6zu triangles\n", std::string(to_string(mesh.kind)).c_str(),
                mesh.positions.size(), mesh.indices.size() / 3);
  const auto road =
      std::find_if(tile.meshes.begin(), tile.meshes.end(), [](const TriMesh& m) { return m.kind == MeshKind::road; });
  if (road == tile.meshes.end()) return 1;
  const double worst_m = largest_difference_m(*road, tile.origin, roadquery::RoadQuery(roads));
  std::printf("the mesh of the road lies within %.0f mm of what is driven\n", 1000.0 * worst_m);
  return worst_m < 0.01 ? 0 : 1;
}
