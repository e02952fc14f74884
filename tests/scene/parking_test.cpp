// Car parks on small sites: asphalt beside roads and buildings, bays whose number is known.

#include "orthodrive/scene/parking.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "orthodrive/scene/scene_layout.hpp"
#include "scene/scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

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
  for (const scene::PlacedParking& one : layout.parking)
    for (const auto& t : one.asphalt) sum += 0.5 * cross(t[1] - t[0], t[2] - t[0]);
  return sum;
}

std::size_t lines(const SceneLayout& layout) {
  std::size_t sum = 0;
  for (const scene::PlacedParking& one : layout.parking) sum += one.lines.size();
  return sum;
}

TEST(Parking, has_rows_of_bays_with_an_aisle_between) {
  const Site site = make_site(480.0, {});
  const auto layout = lay_out(site, {area_at(100.0, 100.0, 40.0, 16.0)});
  EXPECT_NEAR(asphalt_m2(*layout), 640.0, 1e-6);
  EXPECT_EQ(lines(*layout), 2U * 15U) << "sixteen bays a row";
  for (const scene::PlacedParking& one : layout->parking)
    for (const auto& line : one.lines) EXPECT_NEAR(distance(line[1], line[2]), 4.7, 1e-9);
}

TEST(Parking, lies_on_the_terrain_and_beside_roads_and_buildings) {
  const Site site =
      make_site(480.0, {{.start = {west_m, south_m + 108.0}, .length_m = 480.0, .width_m = 6.0, .gradient = 0.03}},
                [](Vec2 p) { return 10.0 + 0.03 * (p.x - west_m); });
  const Building house{.footprint = area_at(110.0, 120.0, 10.0, 10.0)};
  const auto layout = lay_out(site, {area_at(100.0, 100.0, 40.0, 30.0)}, {house});
  EXPECT_NEAR(asphalt_m2(*layout), 1200.0 - 40.0 * 6.1 - 10.05 * 10.1, 4.0);
  EXPECT_GT(lines(*layout), 5U);
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  const TriMesh* asphalt = nullptr;
  for (const TriMesh& mesh : tile.meshes)
    if (mesh.kind == MeshKind::verge && mesh.parts.front().material == SurfaceMaterial::asphalt) asphalt = &mesh;
  ASSERT_NE(asphalt, nullptr);
  expect_upwards(*asphalt);
  EXPECT_NEAR(plan_area_m2(asphalt), asphalt_m2(*layout), 0.1);
  for (const auto& p : asphalt->positions) {
    const Vec3 at = world(tile, p);
    EXPECT_FALSE(layout->roads.outline().contains({at.x, at.y}));
    EXPECT_NEAR(at.z, layout->ground->height_m({at.x, at.y}) + 0.03, 0.02) << "the ground is a plane";
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
  EXPECT_GT(one->parking.size(), 12U);
  EXPECT_NEAR(asphalt_m2(*one), 120000.0, 1e-3);
  ASSERT_EQ(one->parking.size(), four->parking.size());
  for (std::size_t i = 0; i < one->parking.size(); ++i) {
    EXPECT_EQ(one->parking[i].lines.size(), four->parking[i].lines.size());
    EXPECT_EQ(one->parking[i].asphalt.size(), four->parking[i].asphalt.size());
  }
}

}  // namespace
}  // namespace orthodrive
