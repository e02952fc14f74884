// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/coarse_tile.hpp"

#include <cmath>
#include <mutex>
#include <set>
#include <tuple>

#include "sanitized.hpp"
#include "scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

using Key = std::tuple<int, int, int>;  // level, column, row
using Tiles = std::map<Key, SceneTile>;

double hills_m(Vec2 p) { return 20.0 + 8.0 * std::sin(p.x / 37.0) + 5.0 * std::cos(p.y / 23.0); }

/// 16 tiles of level 0 with a road over many borders and one beside a border.
Site hilly_site() {
  return make_site(
      1920.0,
      {{.start = {west_m + 100.0, south_m + 130.3}, .heading_rad = 0.7, .length_m = 1500.0, .z_m = 20.0},
       {.start = {west_m + 483.0, south_m + 20.0}, .heading_rad = 1.5707963267948966, .length_m = 900.0, .z_m = 21.0}},
      hills_m);
}

Tiles build(const SceneInput& input, int threads, SceneResult* result = nullptr) {
  Tiles tiles;
  std::mutex mutex;
  const SceneResult built =
      build_scene(source_of(input),
                  [&](const SceneTile& tile) {
                    const std::lock_guard lock(mutex);
                    EXPECT_TRUE(tiles.emplace(Key{tile.level, tile.column, tile.row}, tile).second);
                  },
                  {.threads = threads});
  if (result != nullptr) *result = built;
  return tiles;
}

using Point = std::array<double, 3>;

/// Ground vertices on a vertical or horizontal line.
std::set<Point> on_line(const SceneTile& tile, bool vertical, double at) {
  std::set<Point> points;
  for (const MeshKind kind : {MeshKind::terrain, MeshKind::road})
    if (const TriMesh* mesh = find_mesh(tile, kind))
      for (const auto& p : mesh->positions)
        if (const Vec3 q = world(tile, p); (vertical ? q.x : q.y) == at) points.insert({q.x, q.y, q.z});
  return points;
}

TEST(CoarseTile, levels_cover_the_ground_without_cracks_between_any_of_them) {
  SceneResult result;
  const Site site = hilly_site();
  const Tiles tiles = build(site.input(), 2, &result);
  EXPECT_EQ(result.levels, 3);
  ASSERT_EQ(tiles.size(), 16U + 4U + 1U);
  std::array<std::size_t, 3> triangles{};
  std::array<double, 3> covered_m2{};
  for (const auto& [key, tile] : tiles) {
    const auto level = static_cast<std::size_t>(tile.level);
    const double side_m = std::ldexp(scene_tile_m, tile.level);
    for (const MeshKind kind : {MeshKind::terrain, MeshKind::road}) {
      const TriMesh* mesh = find_mesh(tile, kind);
      if (mesh == nullptr) continue;
      expect_upwards(*mesh);
      covered_m2[level] += plan_area_m2(mesh);
      triangles[level] += mesh->indices.size() / 3;
      for (const auto& uv : mesh->uv)
        for (const float v : uv) EXPECT_TRUE(v >= 0.0F && v <= 1.0F);
    }
    const double west = tile.column * side_m, south = tile.row * side_m;
    expect_closed(tile, [&](Vec2 a, Vec2 b) {
      return (a.x == b.x && (a.x == west || a.x == west + side_m)) ||
             (a.y == b.y && (a.y == south || a.y == south + side_m));
    });
    if (tile.level == 0) continue;
    // Vertices on the border are those of the tiles of level 0, all of them.
    for (const bool vertical : {true, false})
      for (const double at : {0.0, side_m}) {
        const double line = (vertical ? west : south) + at;
        std::set<Point> finest;
        for (const auto& [other_key, other] : tiles) {
          if (other.level != 0 || other.column >> tile.level != tile.column || other.row >> tile.level != tile.row)
            continue;
          finest.merge(on_line(other, vertical, line));
        }
        EXPECT_GT(finest.size(), 90U);
        EXPECT_EQ(on_line(tile, vertical, line), finest) << "level " << tile.level;
      }
  }
  for (const double m2 : covered_m2) EXPECT_NEAR(m2 / (1920.0 * 1920.0), 1.0, 1e-9);
  EXPECT_LT(triangles[1], triangles[0] / 2);
  EXPECT_LT(triangles[2], triangles[1] / 2);
}

TEST(CoarseTile, stated_error_is_not_smaller_than_the_true_one) {
  const Site site = hilly_site();
  const Tiles tiles = build(site.input(), 2);
  double before_m = 0.0;
  for (int level = 1; level <= 2; ++level) {
    double worst_m = 0.0, stated_m = 0.0;
    for (const auto& [key, tile] : tiles) {
      if (tile.level != level) continue;
      stated_m = std::max(stated_m, tile.geometric_error_m);
      EXPECT_GE(tile.geometric_error_m, std::ldexp(1.0, level)) << "the photo's texels";
    }
    // At the vertices of level 0, from the surface of this level right below or above.
    for (const auto& [key, fine] : tiles) {
      if (fine.level != 0) continue;
      const SceneTile& coarse = tiles.at({level, fine.column >> level, fine.row >> level});
      const auto& terrain = find_mesh(fine, MeshKind::terrain)->positions;
      for (std::size_t i = 0; i < terrain.size(); i += sanitized ? 970 : 97) {
        const Vec3 q = world(fine, terrain[i]);
        double nearest_m = 1e9;
        for (const MeshKind kind : {MeshKind::terrain, MeshKind::road}) {
          const TriMesh* mesh = find_mesh(coarse, kind);
          if (mesh == nullptr) continue;
          for (std::size_t t = 0; t < mesh->indices.size(); t += 3) {
            const Vec3 a = world(coarse, mesh->positions[mesh->indices[t]]),
                       b = world(coarse, mesh->positions[mesh->indices[t + 1]]),
                       c = world(coarse, mesh->positions[mesh->indices[t + 2]]);
            const Vec2 ab{b.x - a.x, b.y - a.y}, ac{c.x - a.x, c.y - a.y}, ap{q.x - a.x, q.y - a.y};
            const double u = cross(ap, ac) / cross(ab, ac), v = cross(ab, ap) / cross(ab, ac);
            if (u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9)
              nearest_m = std::min(nearest_m, std::abs(a.z + u * (b.z - a.z) + v * (c.z - a.z) - q.z));
          }
        }
        worst_m = std::max(worst_m, nearest_m);
      }
    }
    EXPECT_GT(worst_m, 0.05);
    EXPECT_LE(worst_m, stated_m);
    EXPECT_GE(stated_m, before_m);
    before_m = stated_m;
  }
}

TEST(CoarseTile, low_structures_go_and_high_ones_stay) {
  SceneTile tile{.column = 0, .row = 0};
  TriMesh mesh{.kind = MeshKind::structure};
  // Walls of two triangles, 10 m long; the second and third hang together.
  const auto add_wall = [&](float x, float height_m) {
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& p : {std::array{x, 0.0F, 0.0F}, {x, 10.0F, 0.0F}, {x, 10.0F, height_m}, {x, 0.0F, height_m}}) {
      mesh.positions.push_back(p), mesh.normals.push_back({1.0F, 0.0F, 0.0F});
      mesh.tile_uv.push_back({}), mesh.colors.push_back({});
    }
    mesh.indices.insert(mesh.indices.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
  };
  add_wall(0.0F, 0.15F), add_wall(5.0F, 0.3F), add_wall(5.0F, 3.0F);
  mesh.parts = {{SurfaceMaterial::concrete, 0, mesh.indices.size()}};
  tile.meshes.push_back(mesh);
  const SceneTile coarse = scene::coarse_tile(std::vector<const SceneTile*>{&tile}, {});
  const TriMesh* left = find_mesh(coarse, MeshKind::structure);
  ASSERT_TRUE(left);
  for (const auto& p : left->positions) EXPECT_NEAR(p[0] + static_cast<float>(coarse.origin.x), 5.0F, 1e-3F);
  EXPECT_GE(coarse.geometric_error_m, 0.15 - 1e-6);
}

TEST(CoarseTile, photo_is_the_mean_of_four_pixels_and_labels_stay_labels) {
  std::array<SceneTile, 2> tiles;
  for (int k : {0, 1}) {
    SceneTile& tile = tiles[static_cast<std::size_t>(k)];
    tile.column = 6 + k, tile.row = 9;  // the northern half of the parent
    tile.meshes.push_back({MeshKind::terrain, {{0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}}});
    tile.meshes[0].normals.assign(3, {0.0F, 0.0F, 1.0F});
    tile.meshes[0].indices = {0, 1, 2};
    tile.origin = {(6.5 + k) * scene_tile_m, 9.5 * scene_tile_m, 0.0};
    tile.texture_rgb = Raster<std::uint8_t>(4, 4, 3, static_cast<std::uint8_t>(100 + 50 * k));
    tile.texture_rgb.at(0, 0, 0) = 140;
    tile.labels = Raster<std::uint8_t>(4, 4, 1, static_cast<std::uint8_t>(3 + k));
  }
  const SceneTile coarse = scene::coarse_tile(std::array<const SceneTile*, 2>{&tiles[0], &tiles[1]});
  EXPECT_EQ(std::tuple(coarse.level, coarse.column, coarse.row), std::tuple(1, 3, 4));
  ASSERT_EQ(coarse.texture_rgb.width, 4);
  EXPECT_EQ(coarse.texture_rgb.at(0, 0, 0), 110);
  EXPECT_EQ(coarse.texture_rgb.at(1, 1, 0), 100);
  EXPECT_EQ(coarse.texture_rgb.at(2, 1, 1), 150);
  EXPECT_EQ(coarse.texture_rgb.at(0, 2, 0), 128) << "no tile, no photo: grey";
  EXPECT_EQ(coarse.labels.at(1, 0), 3);
  EXPECT_EQ(coarse.labels.at(3, 1), 4);
  EXPECT_EQ(coarse.labels.at(3, 2), label_nodata);
  EXPECT_EQ(coarse.geometric_error_m, 240.0) << "a texel";
}

TEST(CoarseTile, trees_become_lumps_then_fewer_then_none) {
  const Site site = make_site(480.0, {});
  std::vector<Vec2> trees;
  for (int row = 0; row < 20; ++row)
    for (int col = 0; col < 20; ++col) trees.push_back({west_m + 20.0 + 3.0 * col, south_m + 20.0 + 3.0 * row});
  SceneInput input = site.input();
  input.trees = trees;
  SceneTile tile = build_scene_tile(*lay_out_scene(input), {1000, 13000});
  const auto count = [](const SceneTile& of) {
    std::size_t copies = 0;
    for (const InstancedMesh& copied : of.instanced) {
      copies += copied.instances.size();
      if (of.level > 0) {
        EXPECT_EQ(copied.mesh.indices.size(), 48U);
      }
    }
    return copies;
  };
  EXPECT_EQ(count(tile), 400U);
  // A texel of the photo, then half a square of trees, then the tallest tree.
  const std::array<std::size_t, 4> copies = {400, 64, 16, 0};
  const std::array<double, 4> errors_m = {2.0, 4.0, 8.0, 16.0};
  for (std::size_t k = 0; k < 4; ++k) {
    tile = scene::coarse_tile(std::array<const SceneTile*, 1>{&tile});
    EXPECT_EQ(count(tile), copies[k]) << "level " << tile.level;
    EXPECT_GE(tile.geometric_error_m, errors_m[k]);
    EXPECT_LT(tile.geometric_error_m, errors_m[k] + 1.0);
  }
}

TEST(CoarseTile, does_not_depend_on_threads) {
  if (sanitized) GTEST_SKIP() << runs_again;
  const Site site = hilly_site();
  const Tiles one = build(site.input(), 1), three = build(site.input(), 3);
  ASSERT_EQ(one.size(), three.size());
  for (const auto& [key, tile] : one) {
    const SceneTile& other = three.at(key);
    EXPECT_EQ(tile.geometric_error_m, other.geometric_error_m);
    EXPECT_EQ(tile.texture_rgb.data, other.texture_rgb.data);
    ASSERT_EQ(tile.meshes.size(), other.meshes.size());
    for (std::size_t i = 0; i < tile.meshes.size(); ++i) {
      EXPECT_EQ(tile.meshes[i].positions, other.meshes[i].positions);
      EXPECT_EQ(tile.meshes[i].indices, other.meshes[i].indices);
    }
  }
}

}  // namespace
}  // namespace orthodrive
