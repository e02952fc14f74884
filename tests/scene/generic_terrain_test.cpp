// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/generic_terrain.hpp"

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/scene/ground/generic_ground.hpp"
#include "scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

/// A site whose terrain and photo come of its roads.
Site generic_site(const std::vector<RoadShape>& roads) {
  Site site = make_site(480.0, roads);
  const Box2 box = bounds_of(site.area.outer);
  site.terrain = scene::generic_terrain(site.roads, box.grown(50.0), "roads");
  site.photo = window_of(scene::generic_ground({site.roads}, {}, box), box);
  return site;
}

double ground_m(const SceneTile& tile, Vec2 p) { return mesh_height_m(tile, *find_mesh(tile, MeshKind::terrain), p); }

/// Largest distance in height of the ground from the road, so far beside its edges.
double worst_beside_m(const Site& site, const SceneTile& tile, std::size_t index, double beside_m,
                      double from_end_m = 12.0) {
  const roadquery::Road& road = site.roads.roads[index];
  double worst = 0.0;
  for (double s = from_end_m; s < road.length - from_end_m; s += 3.1) {
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    for (const double t : {edges.left_t, edges.right_t}) {
      const auto edge = roadquery::surface_point(road, s, t),
                 off = roadquery::surface_point(road, s, t + (t > 0.0 ? beside_m : -beside_m));
      worst = std::max(worst, std::abs(ground_m(tile, {off.x, off.y}) - edge.z));
    }
  }
  return worst;
}

TEST(GenericTerrain, flat_roads_lie_in_flat_ground) {
  const Site site = generic_site({{.start = {west_m + 80.0, south_m + 100.0}, .heading_rad = 0.5, .z_m = 31.5}});
  for (const float z : site.terrain.height_m.data) ASSERT_NEAR(z, 31.5, 1e-3);
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), {1000, 13000});
  expect_closed(tile, on_tile_border);
  EXPECT_NEAR(worst_beside_m(site, tile, 0, 1.0), 0.0, 1e-3);
}

TEST(GenericTerrain, ground_between_two_roads_rises_evenly) {
  // Both cross the whole box, so the heights depend on the northing alone: a plane.
  Site site = make_site(480.0, {{.start = {west_m - 100.0, south_m + 60.0}, .length_m = 700.0, .z_m = 10.0},
                                {.start = {west_m - 100.0, south_m + 420.0}, .length_m = 700.0, .z_m = 46.0}});
  const HeightGrid terrain =
      scene::generic_terrain(site.roads, {west_m, south_m, west_m + 480.0, south_m + 480.0}, "roads");
  for (double y = 70.0; y < 410.0; y += 20.0)
    EXPECT_NEAR(sample_bilinear(terrain, {west_m + 240.0, south_m + y}), 10.0 + 36.0 * (y - 60.0) / 360.0, 0.4) << y;
  EXPECT_NEAR(sample_bilinear(terrain, {west_m + 240.0, south_m + 10.0}), 10.0, 1e-2);  // level beyond the outer ones
  EXPECT_NEAR(sample_bilinear(terrain, {west_m + 240.0, south_m + 470.0}), 46.0, 1e-2);
}

TEST(GenericTerrain, hilly_and_banked_roads_neither_float_nor_sink) {
  const Site site = generic_site({{.start = {west_m + 60.0, south_m + 90.0},
                                   .heading_rad = 0.4,
                                   .length_m = 320.0,
                                   .z_m = 100.0,
                                   .gradient = 0.09,
                                   .curvature_1pm = 1.0 / 180.0,
                                   .superelevation_rad = 0.05},
                                  {.start = {west_m + 250.0, south_m + 60.0},
                                   .heading_rad = 0.3,
                                   .length_m = 200.0,
                                   .z_m = 95.0,
                                   .gradient = -0.06}});
  const auto [low, high] = std::ranges::minmax(site.terrain.height_m.data);
  EXPECT_GT(low, 95.0F - 0.06F * 200.0F - 0.2F);  // no ground beyond the roads' heights
  EXPECT_LT(high, 100.0F + 0.09F * 320.0F + 0.4F);
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), {1000, 13000});
  expect_closed(tile, on_tile_border);
  for (const std::size_t road : {0U, 1U}) {
    EXPECT_LT(worst_beside_m(site, tile, road, 0.5), 0.15) << road;
    EXPECT_LT(worst_beside_m(site, tile, road, 8.0, 40.0), 1.3) << road;  // a slope of 1 : 6
  }
}

TEST(GenericTerrain, road_over_another_stands_on_banks_and_leaves_the_lower_one_free) {
  const Site site = generic_site(
      {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 400.0, .z_m = 10.0},
       {.start = {west_m + 240.0, south_m + 40.0}, .heading_rad = 0.5 * pi, .length_m = 400.0, .z_m = 17.0}});
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), {1000, 13000});
  const auto beside_upper_m = [&](double y) { return ground_m(tile, {west_m + 246.0, south_m + y}); };
  EXPECT_LT(beside_upper_m(250.0), 13.0);  // near the lower road
  for (const double y : {80.0, 150.0, 330.0, 400.0}) EXPECT_NEAR(beside_upper_m(y), 16.4, 0.7) << y;
  for (double x = 60.0; x < 420.0; x += 7.0)
    for (const double side : {-1.0, 1.0})
      EXPECT_NEAR(ground_m(tile, {west_m + x, south_m + 240.0 + side * 3.5}), 10.0, 0.3) << x;
  for (const auto& p : find_mesh(tile, MeshKind::terrain)->positions) {
    const Vec3 q = world(tile, p);
    const bool is_below = std::abs(q.x - west_m - 240.0) < 2.9 && q.y > south_m + 41.0 && q.y < south_m + 439.0;
    EXPECT_TRUE(!is_below || q.z < 17.0 - 1.0) << q.y - south_m << ' ' << q.z;
  }
}

TEST(GenericTerrain, tunnels_lie_below_the_ground) {
  const Site site =
      generic_site({{.start = {west_m + 40.0, south_m + 200.0}, .length_m = 100.0, .z_m = 50.0},
                    {.start = {west_m + 140.0, south_m + 200.0}, .length_m = 160.0, .z_m = 50.0, .tunnel = true},
                    {.start = {west_m + 300.0, south_m + 200.0}, .length_m = 100.0, .z_m = 50.0}});
  for (double x = 155.0; x < 290.0; x += 5.0)
    EXPECT_GT(sample_bilinear(site.terrain, {west_m + x, south_m + 200.0}), 56.5) << x;
  EXPECT_NEAR(sample_bilinear(site.terrain, {west_m + 90.0, south_m + 200.0}), 50.0, 1e-2);
  for (const Finding& finding : scene_findings(*lay_out_scene(site.input())))
    EXPECT_NE(finding.code, "scene.tunnel_without_cover") << finding.message;
}

TEST(GenericTerrain, cells_grow_where_there_would_be_too_many) {
  const Site site = make_site(480.0, {{.start = {west_m + 80.0, south_m + 100.0}}});
  const HeightGrid terrain = scene::generic_terrain(site.roads, {west_m, south_m, west_m + 480.0, south_m + 480.0},
                                                    "roads", {.cell_m = 1.0, .most_cells = 2304.0});
  EXPECT_DOUBLE_EQ(terrain.frame.gsd_m, 10.0);
  EXPECT_EQ(terrain.height_m.data.size(), 48U * 48U);
}

TEST(GenericTerrain, area_lies_around_the_roads) {
  const Site site = make_site(480.0, {{.start = {west_m + 100.0, south_m + 100.0}, .length_m = 200.0}});
  const Polygon area = scene::area_around_roads(site.roads, 50.0, "roads");
  const Box2 box = bounds_of(area.outer);
  EXPECT_NEAR(box.min_x, west_m + 50.0, 0.01);
  EXPECT_NEAR(box.max_x, west_m + 350.0, 0.01);
  EXPECT_NEAR(box.max_y, south_m + 153.0, 0.01);  // half of the road's width more
  EXPECT_FALSE(contains(area, {west_m + 52.0, south_m + 148.0}));
}

TEST(GenericTerrain, roads_of_different_countries_are_an_error) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m}}, {.start = {west_m + 5e6, south_m}}});
  EXPECT_THROW((void)scene::area_around_roads(site.roads, 50.0, "some.xodr"), InputError);
}

TEST(GenericTerrain, no_roads_are_an_error_that_names_the_file) {
  const roadquery::RoadMap none;
  for (const auto& call : {std::function<void()>([&] { (void)scene::area_around_roads(none, 50.0, "some.xodr"); }),
                           std::function<void()>([&] {
                             (void)scene::generic_terrain(none, {0, 0, 9, 9}, "some.xodr");
                           })})
    try {
      call();
      FAIL();
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("some.xodr: has no road with a surface"), std::string::npos);
    }
}

TEST(GenericGround, roads_are_painted_on_grass_by_what_they_are_made_of) {
  Site site = make_site(480.0, {{.start = {west_m + 40.0, south_m + 100.0}, .length_m = 200.0},
                                {.start = {west_m + 40.0, south_m + 200.0}, .length_m = 200.0},
                                {.start = {west_m + 40.0, south_m + 300.0}, .length_m = 200.0, .tunnel = true}});
  for (roadquery::Lane& lane : site.roads.roads[1].sections[0].left)
    lane.materials = {{.surface = roadquery::SurfaceClass::gravel}};
  const Box2 box = bounds_of(site.area.outer);
  const PhotoSource ground = scene::generic_ground({site.roads}, {}, box);
  const Photo photo = window_of(ground, box);
  const auto at = [&](double x, double y) {
    const Vec2 p = photo.frame.pixel_from_world({west_m + x, south_m + y});
    const std::uint8_t* rgb = &photo.rgb.data[photo.rgb.index(static_cast<int>(p.x), static_cast<int>(p.y))];
    return std::array<int, 3>{rgb[0], rgb[1], rgb[2]};
  };
  const auto is_green = [](const std::array<int, 3>& rgb) { return rgb[1] > rgb[2] + 20; };
  EXPECT_FALSE(is_green(at(100.0, 101.5)));
  EXPECT_LT(at(100.0, 101.5)[0], at(100.0, 201.5)[0]);  // gravel is brighter than asphalt
  EXPECT_EQ(at(100.0, 198.5), at(100.0, 101.5));        // the lane on the right is asphalt
  EXPECT_TRUE(is_green(at(100.0, 104.5)));              // beside the road
  EXPECT_TRUE(is_green(at(100.0, 301.5)));              // over the tunnel
  // A window has the same pixels as the whole.
  const PhotoWindow part = ground.read({300, 500, 64, 64});
  for (int row = 0; row < 64; ++row)
    for (int col = 0; col < 64; ++col)
      ASSERT_EQ(part.rgb.at(col, row), photo.rgb.at(300 + col, 500 + row)) << col << ' ' << row;
}

}  // namespace
}  // namespace orthodrive
