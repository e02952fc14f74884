// SPDX-License-Identifier: Apache-2.0
// Faults that are put into small scenes are found, and nothing else is.
#include "orthodrive/evaluate/scenes/evaluate_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

constexpr double west_m = 480.0 * 1000, south_m = 480.0 * 13000;

/// From west to east through the middles of two tiles, level at 10 m, 6 m wide.
roadquery::RoadQuery road_query() {
  roadquery::Road road;
  road.id = 1, road.length = 900.0;
  road.plan = {{.x = west_m + 30.0, .y = south_m + 240.0, .hdg = 0.0, .length = 900.0}};
  road.elevation = {{.a = 10.0}};
  roadquery::LaneSection section;
  section.left = {{.id = 1, .width = {{.a = 3.0}}}};
  section.right = {{.id = -1, .width = {{.a = 3.0}}}};
  road.sections = {section};
  roadquery::RoadMap map;
  map.roads = {road};
  return roadquery::RoadQuery(std::move(map));
}

/// A grid of 8 x 8 squares of 60 m at 10 m; the row in the middle, less its rim, is road in the second mesh.
SceneTile flat_tile(int column) {
  SceneTile tile{.column = 1000 + column, .row = 13000};
  tile.origin = {west_m + 480.0 * column + 240.0, south_m + 240.0, 8.0};
  TriMesh mesh{.kind = MeshKind::terrain};
  for (int row = 0; row <= 8; ++row)
    for (int col = 0; col <= 8; ++col) {
      mesh.positions.push_back(
          {60.0F * static_cast<float>(col) - 240.0F, 60.0F * static_cast<float>(row) - 240.0F, 2.0F});
      mesh.normals.push_back({0.0F, 0.0F, 1.0F});
    }
  for (std::uint32_t row = 0; row < 8; ++row)
    for (std::uint32_t col = 0; col < 8; ++col) {
      const std::uint32_t a = 9 * row + col;
      mesh.indices.insert(mesh.indices.end(), {a, a + 1, a + 10, a, a + 10, a + 9});
    }
  tile.meshes = {mesh};
  return tile;
}

SceneScores score(const std::vector<SceneTile>& tiles) {
  const roadquery::RoadQuery roads = road_query();
  SceneScorer scorer(roads);
  for (const SceneTile& tile : tiles) scorer.add(tile, 1000);
  return scorer.finish();
}

TEST(EvaluateScene, a_sound_scene_has_no_fault) {
  const SceneScores scores = score({flat_tile(0), flat_tile(1)});
  EXPECT_EQ(scores.tiles, 2U);
  EXPECT_EQ(scores.bytes, 2000U);
  EXPECT_EQ(scores.triangles, 256U);
  EXPECT_EQ(scores.draw_calls, 2U);
  EXPECT_NEAR(scores.ground_km2, 2.0 * 0.48 * 0.48, 1e-9);
  EXPECT_EQ(scores.open_edges, 0U);
  EXPECT_EQ(scores.crowded_edges, 0U);
  EXPECT_GE(scores.shared_vertices, 9U);
  EXPECT_EQ(scores.normal_error_deg, 0.0);
  EXPECT_TRUE(scores.faults.empty());
}

TEST(EvaluateScene, cracks_are_found_within_tiles_and_between_them) {
  SceneTile holed = flat_tile(0);
  holed.meshes[0].indices.erase(holed.meshes[0].indices.begin() + 60, holed.meshes[0].indices.begin() + 63);
  EXPECT_EQ(score({holed, flat_tile(1)}).open_edges, 3U);

  SceneTile shifted = flat_tile(1);  // one vertex of the common border 1 mm lower
  shifted.meshes[0].positions[9 * 4][2] -= 1.0F / 1024.0F;
  const SceneScores scores = score({flat_tile(0), shifted});
  EXPECT_EQ(scores.open_edges, 4U);
  ASSERT_FALSE(scores.faults.empty());
  EXPECT_EQ(scores.faults[0].code, "scene.crack");
  EXPECT_NEAR(scores.faults[0].x_m, west_m + 480.0, 61.0);
}

TEST(EvaluateScene, edges_of_three_triangles_are_counted) {
  SceneTile tile = flat_tile(0);
  tile.meshes[0].indices.insert(tile.meshes[0].indices.end(), {20, 21, 31});
  EXPECT_GE(score({tile}).crowded_edges, 1U);
}

TEST(EvaluateScene, roads_beside_their_surface_and_bent_normals_are_measured) {
  SceneTile tile = flat_tile(0), next = flat_tile(1);
  TriMesh road{.kind = MeshKind::road};
  for (const auto& [x, y, z] : {std::array{-100.0F, -2.0F, 2.0F}, {100.0F, -2.0F, 2.0F}, {0.0F, 2.0F, 2.06F}}) {
    road.positions.push_back({x, y, z});
    road.normals.push_back({0.0F, 0.0F, 1.0F});
  }
  road.indices = {0, 1, 2};
  tile.meshes.push_back(road);
  const float lean = std::sin(0.5F * 3.14159265F / 180.0F);
  next.meshes[0].normals[9 * 3] = {lean, 0.0F, std::sqrt(1.0F - lean * lean)};
  const SceneScores scores = score({tile, next});
  EXPECT_EQ(scores.road_samples, 4U);
  EXPECT_NEAR(scores.road_error_m, 0.03, 1e-3) << "half of the way up an edge";
  EXPECT_EQ(scores.road_samples_off, 2U);
  EXPECT_NEAR(scores.normal_error_deg, 0.5, 1e-3);
}

TEST(EvaluateScene, what_stands_on_a_road_is_found_but_not_what_touches_it_or_hangs_over_it) {
  const auto with = [](float y, float z) {
    SceneTile tile = flat_tile(0);
    TriMesh wall{.kind = MeshKind::barrier, .positions = {{0.0F, y, z}}, .normals = {{0.0F, 0.0F, 1.0F}}};
    tile.meshes.push_back(wall);
    InstancedMesh tree{.mesh = {.kind = MeshKind::tree, .positions = {{0.5F, 0.0F, 0.1F}}, .normals = {{0, 0, 1}}}};
    // Turned by a quarter and stretched: 2 m to the north of its foot.
    tree.instances = {{.position = {50.0F, y - 2.0F, z}, .yaw_rad = 1.5707963F, .scale = {4.0F, 4.0F, 4.0F}}};
    tile.instanced.push_back(tree);
    return score({tile}).on_road;
  };
  EXPECT_EQ(with(1.0F, 2.5F), 2U);
  EXPECT_EQ(with(-2.9F, 2.5F), 2U);
  EXPECT_EQ(with(3.0F, 2.5F), 0U);
  EXPECT_EQ(with(5.0F, 2.5F), 0U);
  EXPECT_EQ(with(1.0F, 7.0F), 0U);
}

/// A box of 10 m without a floor, its roof at 14 m over the ground's 10 m; places from the tile's middle.
TriMesh box_at(float x, float y) {
  TriMesh box{.kind = MeshKind::building};
  const std::array<std::array<float, 2>, 4> c = {{{x, y}, {x + 10.0F, y}, {x + 10.0F, y + 10.0F}, {x, y + 10.0F}}};
  for (const float z : {1.5F, 6.0F})
    for (const auto& p : c) box.positions.push_back({p[0], p[1], z}), box.normals.push_back({0.0F, 0.0F, 1.0F});
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t n = (k + 1) % 4;
    box.indices.insert(box.indices.end(), {k, n, n + 4, k, n + 4, k + 4});
  }
  box.indices.insert(box.indices.end(), {4, 5, 6, 4, 6, 7});
  return box;
}

TEST(EvaluateScene, what_stands_in_a_building_is_found_but_not_what_stands_on_it) {
  const auto with = [](MeshKind kind, float x, float y, float z) {
    SceneTile tile = flat_tile(0), next = flat_tile(1);
    tile.meshes.push_back(box_at(50.0F, 50.0F));
    tile.meshes.push_back(box_at(235.0F, -150.0F));  // half of it lies in the next tile
    TriMesh thing{.kind = kind, .positions = {{x, y, z}}, .normals = {{0.0F, 0.0F, 1.0F}}};
    if (x > 240.0F) thing.positions[0][0] -= 480.0F;
    (x > 240.0F ? next : tile).meshes.push_back(thing);
    return std::array{score({tile, next}).in_building, score({next, tile}).in_building};
  };
  const auto both = [](std::size_t count) { return std::array{count, count}; };
  EXPECT_EQ(with(MeshKind::tree, 55.0F, 53.0F, 3.0F), both(1));
  EXPECT_EQ(with(MeshKind::barrier, 55.0F, 53.0F, 3.0F), both(1));
  EXPECT_EQ(with(MeshKind::building, 55.0F, 53.0F, 3.0F), both(0));
  EXPECT_EQ(with(MeshKind::tree, 49.9F, 53.0F, 3.0F), both(0));
  EXPECT_EQ(with(MeshKind::object, 55.0F, 53.0F, 6.5F), both(0)) << "on the roof";
  EXPECT_EQ(with(MeshKind::tree, 244.0F, -143.0F, 3.0F), both(1)) << "a neighbour's building";
  EXPECT_EQ(with(MeshKind::tree, 246.0F, -143.0F, 3.0F), both(0));
}

}  // namespace
}  // namespace orthodrive
