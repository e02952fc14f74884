// SPDX-License-Identifier: Apache-2.0
// Hedges, walls, railways, lamps and water on small sites: where they stand, and that nothing stands on a road.

#include "orthodrive/scene/objects/line_objects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/tiles/coarse_tile.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "scene/placed.hpp"
#include "scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

Vec2 line_at(double east_m, double north_m) { return {west_m + east_m, south_m + north_m}; }

std::shared_ptr<const SceneLayout> lay_out_lines(const Site& site, const MapSurroundings& surroundings,
                                                 const std::vector<Building>& buildings = {}) {
  SceneInput input = site.input();
  input.surroundings = &surroundings;
  input.buildings = buildings;
  return lay_out_scene(input);
}

std::size_t count(const std::map<TileAddress, std::vector<scene::StructureFace>>& tiles) {
  std::size_t faces = 0;
  for (const auto& [address, of_tile] : tiles) faces += of_tile.size();
  return faces;
}

TEST(LineObjects, a_wall_in_the_open_is_a_box_on_the_ground) {
  const Site site = make_site(480.0, {}, [](Vec2 p) { return 10.0 + 0.1 * (p.x - west_m); });
  const auto layout =
      lay_out_lines(site, {.barriers = {{BarrierKind::wall, {line_at(100, 100), line_at(140, 100)}},
                                        {BarrierKind::hedge, {line_at(100, 200), line_at(120, 200)}, 2.0}}});
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  double low = 1e9, high = -1e9, hedge_high = -1e9;
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind != MeshKind::barrier) continue;
    ASSERT_EQ(mesh.parts.size(), 1U);
    const bool is_hedge = mesh.parts[0].material == SurfaceMaterial::foliage;
    for (const auto& position : mesh.positions) {
      const Vec3 p = world(tile, position);
      const double over = p.z - 10.0 - 0.1 * (p.x - west_m);
      EXPECT_LE(std::abs(p.y - south_m - (is_hedge ? 200.0 : 100.0)), (is_hedge ? 0.4 : 0.15) + 1e-4);
      if (is_hedge) {
        hedge_high = std::max(hedge_high, over);
      } else {
        low = std::min(low, over), high = std::max(high, over);
      }
    }
  }
  EXPECT_NEAR(low, -0.4, 0.01);
  EXPECT_NEAR(high, 1.6, 0.01);
  EXPECT_NEAR(hedge_high, 2.0, 0.01) << "the map's height";
}

TEST(LineObjects, none_stands_on_a_road_or_in_a_building) {
  const Site site =
      make_site(480.0, {{.start = line_at(40, 240), .length_m = 400.0},
                        {.start = line_at(240, 40), .heading_rad = 1.2, .length_m = 380.0, .width_m = 9.0},
                        {.start = line_at(60, 60), .length_m = 300.0, .curvature_1pm = 0.004}});
  std::vector<Building> buildings;
  for (int k = 0; k < 12; ++k) {
    const Vec2 p = line_at(60.0 + 33.0 * k, 300.0 - 9.0 * k);
    buildings.push_back({.footprint = {{p, p + Vec2{14.0, 3.0}, p + Vec2{11.0, 12.0}, p + Vec2{-3.0, 9.0}}, {}}});
  }
  MapSurroundings surroundings;
  Random random(7);
  const auto anywhere = [&] { return line_at(random.uniform(0.0, 480.0), random.uniform(0.0, 480.0)); };
  for (int k = 0; k < 60; ++k) {
    Polyline line = {anywhere()};  // zigzags, some corners sharp
    for (int i = 0; i < 4; ++i) line.push_back(line.back() + (anywhere() - line_at(240, 240)) * 0.15);
    if (k % 3 == 0) {
      surroundings.tracks.push_back(std::move(line));
    } else {
      surroundings.barriers.push_back({static_cast<BarrierKind>(k % 4), std::move(line)});
    }
  }
  const auto layout = lay_out_lines(site, surroundings, buildings);
  ASSERT_GE(layout->buildings.size(), 8U);
  EXPECT_GT(count(scene::placed_faces(*layout, MeshKind::barrier)), 500U);
  EXPECT_GT(count(scene::placed_faces(*layout, MeshKind::track)), 500U);
  MultiPolygon taken = layout->roads.polygons();
  for (const scene::PlacedBuilding& building : layout->buildings)
    taken.push_back(moved(building.footprint, building.middle));
  EXPECT_EQ(shared_m2(scene::placed_faces(*layout, MeshKind::barrier), taken), 0.0);
  EXPECT_EQ(shared_m2(scene::placed_faces(*layout, MeshKind::track), taken), 0.0);
}

TEST(LineObjects, tracks_run_below_high_decks_but_not_below_low_ones) {
  const auto bridge = [](double z_m) {
    return make_site(480.0, {{.start = line_at(40, 240), .length_m = 400.0, .z_m = z_m, .layer = 1, .bridge = true}});
  };
  const MapSurroundings surroundings{.tracks = {{line_at(200, 100), line_at(200, 380)}}};
  const auto under = [&](double z_m) {
    std::size_t faces = 0;
    const Site site = bridge(z_m);  // its roads must outlive the layout
    const auto layout = lay_out_lines(site, surroundings);
    for (const auto& [address, of_tile] : scene::placed_faces(*layout, MeshKind::track))
      for (const scene::StructureFace& face : of_tile)
        faces += static_cast<std::size_t>(std::abs(face.corners[0].y - south_m - 240.0) < 3.5);
    return faces;
  };
  EXPECT_GT(under(17.0), 0U);
  EXPECT_EQ(under(13.0), 0U);
}

TEST(LineObjects, lamps_stand_beside_the_road_and_look_at_it) {
  const Site site = make_site(480.0, {{.start = line_at(40, 240), .length_m = 400.0}});
  const auto layout =
      lay_out_lines(site, {.lamps = {line_at(100, 244), line_at(150, 236.5), line_at(200, 240.5), line_at(250, 300)}});
  ASSERT_EQ(scene::placed<scene::PlacedLamp>(*layout).size(), 3U) << "one was on the road";
  EXPECT_NEAR(scene::placed<scene::PlacedLamp>(*layout)[0].yaw_rad, -0.5 * pi, 1e-6);
  EXPECT_NEAR(scene::placed<scene::PlacedLamp>(*layout)[1].yaw_rad, 0.5 * pi, 1e-6);
  SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  ASSERT_EQ(tile.instanced.size(), 1U);
  EXPECT_EQ(tile.instanced[0].instances.size(), 3U);
  EXPECT_NEAR(tile.max_z_m, 16.0, 0.01);
  for (const auto& p : tile.instanced[0].mesh.positions) EXPECT_LE(std::hypot(p[0], p[1]), 1.0F);
  tile = scene::ready_to_coarsen(std::move(tile));
  EXPECT_TRUE(tile.instanced.empty()) << "too thin for coarse levels";
}

TEST(LineObjects, odd_lines_give_nothing) {
  const Site site = make_site(480.0, {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto layout = lay_out_lines(site, {.barriers = {{BarrierKind::wall, {line_at(100, 100), line_at(100, 100)}},
                                                        {BarrierKind::wall, {line_at(100, 100), {nan, 0.0}}},
                                                        {BarrierKind::hedge, {line_at(-500, 0), line_at(-400, 0)}},
                                                        {BarrierKind::fence, {line_at(0, 0), line_at(1e9, 0)}}},
                                           .tracks = {{line_at(50, 50)}, {}}});
  EXPECT_EQ(
      count(scene::placed_faces(*layout, MeshKind::barrier)) + count(scene::placed_faces(*layout, MeshKind::track)),
      0U);
}

/// A lake of 100 m in a hollow, whose map outline has a road run through it.
Site lake_site() {
  return make_site(
      480.0, {{.start = line_at(150, 40), .heading_rad = 0.5 * pi, .length_m = 400.0, .z_m = 12.0}},
      [](Vec2 p) { return 8.0 + std::clamp((distance(p, line_at(150, 200)) - 60.0) / 10.0, 0.0, 1.0) * 4.0; });
}

TEST(Water, lies_at_one_level_beside_the_road_without_a_crack) {
  const Site site = lake_site();
  const MapSurroundings surroundings{.water = {{square(west_m + 100.0, south_m + 150.0, 100.0), {}}}};
  const auto layout = lay_out_lines(site, surroundings);
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  const TriMesh* water = find_mesh(tile, MeshKind::water);
  ASSERT_TRUE(water);
  expect_upwards(*water);
  EXPECT_NEAR(scene_test::plan_area_m2(water), (100.0 - 6.0 - 10.0) * 100.0, 30.0) << "without road and verges";
  for (std::size_t i = 0; i < water->positions.size(); ++i) {
    const Vec3 p = world(tile, water->positions[i]);
    EXPECT_NEAR(p.z, 8.0, 1e-6);
    EXPECT_GE(std::abs(p.x - west_m - 150.0), 8.0 - 0.01);
    EXPECT_EQ(water->normals[i][2], 1.0F);
  }
  expect_closed(tile, on_tile_border);
  const SceneTile coarse = scene::coarse_tile(std::array<const SceneTile*, 1>{&tile});
  EXPECT_FALSE(find_mesh(coarse, MeshKind::water)) << "joined with the terrain, it shows the photo";
  EXPECT_NEAR(scene_test::plan_area_m2(find_mesh(coarse, MeshKind::terrain)) +
                  scene_test::plan_area_m2(find_mesh(coarse, MeshKind::road)),
              480.0 * 480.0, 1.0);
}

TEST(Water, that_falls_has_no_level) {
  const Site site = make_site(480.0, {}, [](Vec2 p) { return 0.1 * (p.x - west_m); });
  const MapSurroundings surroundings{.water = {{square(west_m + 100.0, south_m + 150.0, 100.0), {}},
                                               {square(west_m + 300.0, south_m + 150.0, 20.0), {}},
                                               {square(west_m + 310.0, south_m + 160.0, 20.0), {}},
                                               {{line_at(0, 0), line_at(10, 0)}, {}}}};
  const auto layout = lay_out_lines(site, surroundings);
  ASSERT_EQ(layout->waters.bodies().size(), 2U);
  EXPECT_NEAR(layout->waters.bodies()[0].level_m, 30.5, 0.3) << "the lower quartile";
  double area = 0.0;
  for (const Polygon& part : layout->waters.bodies()[1].shores) area += area_m2(part);
  EXPECT_NEAR(area, 300.0, 0.1) << "what both share is the first one's";
  const Findings& findings = scene_findings(*layout);
  EXPECT_EQ(std::ranges::count(findings, std::string("scene.water_slope"), &Finding::code), 1);
  expect_closed(build_scene_tile(*layout, {1000, 13000}), on_tile_border);
}

}  // namespace
}  // namespace orthodrive
