// SPDX-License-Identifier: Apache-2.0
// Car parks, paths and gravel on small sites: beside roads and buildings, areas and bays whose number is known.

#include "orthodrive/scene/plants/ground_cover.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "scene/scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;
using roadquery::SurfaceClass;

Polygon area_at(double east_m, double north_m, double width_m, double depth_m) {
  const double x = west_m + east_m, y = south_m + north_m;
  return {{{x, y}, {x + width_m, y}, {x + width_m, y + depth_m}, {x, y + depth_m}}, {}};
}

std::shared_ptr<const SceneLayout> lay_out(const Site& site, const MultiPolygon& parking,
                                           std::vector<Building> buildings = {}, int threads = 0) {
  MapSurroundings surroundings;
  surroundings.parking = parking;
  SceneInput input = site.input();
  input.surroundings = &surroundings;
  input.buildings = buildings;
  return lay_out_scene(input, {.threads = threads});
}

double asphalt_m2(const SceneLayout& layout) {
  double sum = 0.0;
  for (const scene::PlacedCover& one : layout.covers)
    for (const auto& t : one.faces) sum += 0.5 * cross(t[1] - t[0], t[2] - t[0]);
  return sum;
}

std::size_t lines(const SceneLayout& layout) {
  std::size_t sum = 0;
  for (const scene::PlacedCover& one : layout.covers) sum += one.lines.size();
  return sum;
}

TEST(Parking, has_rows_of_bays_with_an_aisle_between) {
  const Site site = make_site(480.0, {});
  const auto layout = lay_out(site, {area_at(100.0, 100.0, 40.0, 16.0)});
  EXPECT_NEAR(asphalt_m2(*layout), 640.0, 1e-6);
  EXPECT_EQ(lines(*layout), 2U * 15U) << "sixteen bays a row";
  for (const scene::PlacedCover& one : layout->covers)
    for (const auto& line : one.lines) EXPECT_NEAR(distance(line[1], line[2]), 4.7, 1e-9);
}

TEST(Parking, lies_on_the_terrain_and_beside_roads_and_buildings) {
  const Site site =
      make_site(480.0, {{.start = {west_m, south_m + 108.0}, .length_m = 480.0, .width_m = 6.0, .gradient = 0.03}},
                [](Vec2 p) { return 10.0 + 0.03 * (p.x - west_m); });
  const Building house{.footprint = area_at(110.0, 120.0, 10.0, 10.0)};
  const auto layout = lay_out(site, {area_at(100.0, 100.0, 40.0, 30.0)}, {house});
  EXPECT_GT(lines(*layout), 5U);
  for (const scene::PlacedCover& cover : layout->covers) {
    for (const auto& line : cover.lines) {
      for (const Vec2 p : line) {
        EXPECT_FALSE(layout->roads.outline().contains(p));
        EXPECT_FALSE(contains(house.footprint, p));
      }
    }
  }
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  const TriMesh* asphalt = nullptr;
  for (const TriMesh& mesh : tile.meshes)
    if (mesh.kind == MeshKind::verge && mesh.parts.front().material == SurfaceMaterial::asphalt) asphalt = &mesh;
  ASSERT_NE(asphalt, nullptr);
  expect_upwards(*asphalt);
  EXPECT_NEAR(plan_area_m2(asphalt), 1200.0 - 40.0 * 6.0, 0.1);
  for (const auto& p : asphalt->positions) {
    const Vec3 cover_at = world(tile, p);
    const Vec2 p2{cover_at.x, cover_at.y};
    EXPECT_TRUE(!layout->roads.outline().contains(p2) || layout->roads.outline().nearest(p2).distance_m < 2e-3);
    EXPECT_NEAR(cover_at.z, layout->ground->height_m({cover_at.x, cover_at.y}) + 0.03, 0.02) << "the ground is a plane";
  }
}

TEST(Parking, odd_areas_are_passed_over_or_mended) {
  const Site site = make_site(480.0, {});
  const double x = west_m + 240.0, y = south_m + 240.0;
  Polygon bow{{{x, y}, {x + 20.0, y + 20.0}, {x + 20.0, y}, {x, y + 20.0}}, {}};  // crosses itself
  Polygon line{{{x, y}, {x + 50.0, y}, {x + 100.0, y}}, {}};
  const auto layout = lay_out(site, {bow, line, {}, area_at(-900.0, 0.0, 50.0, 50.0), area_at(10.0, 10.0, 3.0, 3.0)});
  EXPECT_NEAR(asphalt_m2(*layout), 200.0, 0.1);
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  for (const TriMesh& mesh : tile.meshes)
    if (mesh.kind == MeshKind::verge) expect_upwards(mesh);
}

TEST(Parking, larger_than_a_square_is_the_same_from_one_or_four_threads) {
  const Site site = make_site(480.0, {});
  const MultiPolygon areas = {area_at(20.0, 20.0, 400.0, 300.0)};
  const auto one = lay_out(site, areas, {}, 1), four = lay_out(site, areas, {}, 4);
  EXPECT_GT(one->covers.size(), 12U);
  EXPECT_NEAR(asphalt_m2(*one), 120000.0, 1e-3);
  ASSERT_EQ(one->covers.size(), four->covers.size());
  for (std::size_t i = 0; i < one->covers.size(); ++i) {
    EXPECT_EQ(one->covers[i].lines.size(), four->covers[i].lines.size());
    EXPECT_EQ(one->covers[i].faces.size(), four->covers[i].faces.size());
  }
}

std::shared_ptr<const SceneLayout> lay_out(const Site& site, const MapSurroundings& surroundings,
                                           const LabelMap* labels = nullptr) {
  SceneInput input = site.input();
  input.surroundings = &surroundings;
  input.labels = labels;
  return lay_out_scene(input, {});
}

double area_of(const SceneLayout& layout, SurfaceMaterial material) {
  double sum = 0.0;
  for (const scene::PlacedCover& one : layout.covers)
    if (one.material == material)
      for (const auto& t : one.faces) sum += 0.5 * cross(t[1] - t[0], t[2] - t[0]);
  return sum;
}

/// As drawn, on the one tile.
double drawn_m2(const SceneLayout& layout, SurfaceMaterial material) {
  double sum = 0.0;
  const SceneTile tile = build_scene_tile(layout, {1000, 13000});
  for (const TriMesh& mesh : tile.meshes) {
    if (mesh.kind != MeshKind::verge || mesh.parts.front().material != material) continue;
    expect_upwards(mesh);
    sum += plan_area_m2(&mesh);
  }
  return sum;
}

Vec2 cover_at(double east_m, double north_m) { return {west_m + east_m, south_m + north_m}; }

TEST(GroundCover, paths_have_their_width_and_end_at_roads) {
  const Site site = make_site(480.0, {{.start = cover_at(0.0, 108.0), .length_m = 480.0, .width_m = 6.0}});
  MapSurroundings surroundings;
  // Across the road, and bent by a right angle.
  surroundings.paths.push_back({{cover_at(100.0, 50.0), cover_at(100.0, 150.0)}, 2.0, SurfaceClass::asphalt});
  surroundings.paths.push_back(
      {{cover_at(200.0, 200.0), cover_at(230.0, 200.0), cover_at(230.0, 240.0)}, 2.0, SurfaceClass::setts});
  const auto layout = lay_out(site, surroundings);
  EXPECT_NEAR(drawn_m2(*layout, SurfaceMaterial::asphalt), 200.0 - 2.0 * 6.0, 0.1);
  EXPECT_NEAR(drawn_m2(*layout, SurfaceMaterial::setts), 140.0, 0.05);
}

TEST(GroundCover, paths_that_meet_or_reach_into_car_parks_lie_once) {
  const Site site = make_site(480.0, {});
  MapSurroundings surroundings;
  surroundings.parking = {area_at(100.0, 100.0, 40.0, 16.0)};
  surroundings.paths.push_back({{cover_at(80.0, 108.0), cover_at(120.0, 108.0)}, 2.0, SurfaceClass::asphalt});
  surroundings.paths.push_back({{cover_at(90.0, 80.0), cover_at(90.0, 130.0)}, 2.0, SurfaceClass::asphalt});
  const auto layout = lay_out(site, surroundings);
  EXPECT_NEAR(area_of(*layout, SurfaceMaterial::asphalt), 640.0 + 40.0 + 100.0 - 4.0, 0.05);
}

TEST(GroundCover, gravel_lies_around_what_is_paved) {
  const Site site = make_site(480.0, {{.start = cover_at(0.0, 108.0), .length_m = 480.0, .width_m = 6.0}});
  MapSurroundings surroundings;
  surroundings.gravel = {area_at(200.0, 80.0, 60.0, 40.0)};
  surroundings.paths.push_back({{cover_at(230.0, 60.0), cover_at(230.0, 100.0)}, 2.0, SurfaceClass::ground});
  const auto layout = lay_out(site, surroundings);
  EXPECT_NEAR(drawn_m2(*layout, SurfaceMaterial::gravel), 2400.0 - 60.0 * 6.0 - 20.0 * 2.0, 0.1);
  EXPECT_NEAR(drawn_m2(*layout, SurfaceMaterial::ground), 80.0, 0.05);
}

TEST(GroundCover, trees_over_a_path_do_not_colour_it) {
  Site site = make_site(480.0, {});
  std::ranges::fill(site.photo.rgb.data, std::uint8_t{188});  // linear 0.5
  LabelMap labels{site.photo.crs, site.photo.frame,
                  Raster<std::uint8_t>(site.photo.frame.width, site.photo.frame.height), default_class_table()};
  for (int row = 0; row < site.photo.frame.height; ++row) {
    for (int col = 0; col < site.photo.frame.width; ++col) {
      if (site.photo.frame.center_of(col, row).x > west_m + 40.0) continue;
      labels.labels.at(col, row) = 4;  // vegetation
      for (int c = 0; c < 3; ++c) site.photo.rgb.at(col, row, c) = 30;
    }
  }
  MapSurroundings surroundings;
  surroundings.paths.push_back({{cover_at(5.0, 200.0), cover_at(60.0, 200.0)}, 4.0, SurfaceClass::asphalt});
  const auto layout = lay_out(site, surroundings, &labels);
  ASSERT_FALSE(layout->covers.empty());
  EXPECT_NEAR(layout->covers.front().color[0], 0.5F, 0.01F);
}

TEST(GroundCover, odd_paths_are_passed_over) {
  const Site site = make_site(480.0, {});
  MapSurroundings surroundings;
  surroundings.paths.push_back({{cover_at(50.0, 50.0), cover_at(50.0, 50.0)}, 2.0, SurfaceClass::asphalt});
  surroundings.paths.push_back({{cover_at(50.0, 50.0)}, 2.0, SurfaceClass::asphalt});
  surroundings.paths.push_back({{}, 2.0, SurfaceClass::asphalt});
  surroundings.paths.push_back(
      {{cover_at(60.0, 50.0), cover_at(90.0, 50.0), cover_at(60.0, 50.0)}, 2.0, SurfaceClass::asphalt});
  surroundings.paths.push_back({{cover_at(-5000.0, 50.0), cover_at(-4000.0, 50.0)}, 2.0, SurfaceClass::asphalt});
  EXPECT_NEAR(area_of(*lay_out(site, surroundings), SurfaceMaterial::asphalt), 60.0, 0.05);
}

}  // namespace
}  // namespace orthodrive
