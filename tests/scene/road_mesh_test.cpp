// SPDX-License-Identifier: Apache-2.0
// The road mesh keeps to the roads' surface within 2 cm, everywhere and not only at its vertices; its triangles keep to
// lanes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/plan/triangulate.hpp"
#include "orthodrive/scene/roads/crossing_roads.hpp"
#include "roadquery/query/road_query.hpp"
#include "scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

/// Of the middles of all road triangles and their edges from the road query's surface.
double worst_m(const Site& site, const std::vector<SceneTile>& tiles) {
  const roadquery::RoadQuery query(site.roads);
  double worst = 0.0;
  for (const SceneTile& tile : tiles) {
    const TriMesh* mesh = find_mesh(tile, MeshKind::road);
    for (std::size_t i = 0; mesh != nullptr && i < mesh->indices.size(); i += 3) {
      std::array<Vec3, 3> c;
      for (std::size_t k = 0; k < 3; ++k) c[k] = world(tile, mesh->positions[mesh->indices[i + k]]);
      for (const Vec3& p :
           {(c[0] + c[1] + c[2]) * (1.0 / 3.0), (c[0] + c[1]) * 0.5, (c[1] + c[2]) * 0.5, (c[2] + c[0]) * 0.5}) {
        roadquery::Cursor cursor;
        const auto z = query.find_height(p.x, p.y, p.z, cursor);
        if (z) worst = std::max(worst, std::abs(*z - p.z));
      }
    }
  }
  return worst;
}

std::vector<SceneTile> build_tiles(const Site& site) {
  const auto layout = lay_out_scene(site.input());
  std::vector<SceneTile> tiles;
  for (const TileAddress address : scene_tiles(*layout)) tiles.push_back(build_scene_tile(*layout, address));
  return tiles;
}

void add_crown(roadquery::Road& road, double fall) {
  road.shape.push_back({0.0, -30.0, -30.0 * fall, fall, 0.0, 0.0});
  road.shape.push_back({0.0, 0.0, 0.0, -fall, 0.0, 0.0});
}

std::size_t road_triangles(const std::vector<SceneTile>& tiles) {
  std::size_t count = 0;
  for (const SceneTile& tile : tiles)
    if (const TriMesh* mesh = find_mesh(tile, MeshKind::road)) count += mesh->indices.size() / 3;
  return count;
}

TEST(RoadMesh, crowned_road_with_a_twist_stays_within_two_centimetres) {
  Site site = make_site(480.0, {{.start = {west_m + 60.0, south_m + 90.0},
                                 .heading_rad = 0.5,
                                 .length_m = 120.0,
                                 .width_m = 14.0,
                                 .curvature_1pm = 1.0 / 80.0}});
  site.roads.roads[0].superelevation = {{.a = -0.06, .b = 0.12 / 60.0}};
  add_crown(site.roads.roads[0], 0.04);
  const auto tiles = build_tiles(site);
  EXPECT_LT(worst_m(site, tiles), 0.02);
  EXPECT_LT(road_triangles(tiles), 2000U);
  expect_upwards(*find_mesh(tiles[0], MeshKind::road));
  expect_closed(tiles[0], on_tile_border);
}

TEST(RoadMesh, road_on_a_tile_border_has_the_same_vertices_on_both_sides) {
  // The border runs along the reference line, and along an edge of the second road.
  Site site = make_site(
      960.0,
      {{.start = {west_m + 480.0, south_m + 30.0}, .heading_rad = 0.5 * pi, .length_m = 200.0},
       {.start = {west_m + 483.0, south_m + 600.0}, .heading_rad = 0.5 * pi, .length_m = 200.0, .gradient = 0.03}});
  for (roadquery::Road& road : site.roads.roads) add_crown(road, 0.05);
  const auto tiles = build_tiles(site);
  EXPECT_LT(worst_m(site, tiles), 0.02);
  double area_m2 = 0.0;
  std::vector<Vec3> west, east;
  for (const SceneTile& tile : tiles) {
    expect_closed(tile, on_tile_border);
    const TriMesh* mesh = find_mesh(tile, MeshKind::road);
    area_m2 += plan_area_m2(mesh);
    if (mesh == nullptr || tile.row != 13000) continue;
    for (const auto& p : mesh->positions)
      if (const Vec3 q = world(tile, p); q.x == west_m + 480.0) (tile.column == 1000 ? west : east).push_back(q);
  }
  EXPECT_NEAR(area_m2, 2.0 * 200.0 * 6.0, 0.5);
  const auto places = [](const std::vector<Vec3>& points) {
    std::vector<std::array<double, 3>> sorted;
    for (const Vec3& p : points) sorted.push_back({p.x, p.y, p.z});
    std::ranges::sort(sorted);
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    return sorted;
  };
  EXPECT_FALSE(west.empty());
  EXPECT_EQ(places(west), places(east));
}

TEST(RoadMesh, thirty_roads_that_meet_are_one_surface) {
  std::vector<RoadShape> shapes;
  for (int i = 0; i < 30; ++i)
    shapes.push_back(
        {.start = {west_m + 240.0, south_m + 240.0}, .heading_rad = 2.0 * pi * i / 30.0, .length_m = 90.0});
  Site site = make_site(480.0, shapes);
  for (roadquery::Road& road : site.roads.roads) add_crown(road, 0.01);
  const auto tiles = build_tiles(site);
  EXPECT_LT(worst_m(site, tiles), 0.02);
  expect_upwards(*find_mesh(tiles[0], MeshKind::road));
  expect_closed(tiles[0], on_tile_border);
}

TEST(RoadMesh, road_narrower_than_a_triangle_is_there_as_a_whole) {
  const Site site = make_site(480.0, {{.start = {west_m + 60.0, south_m + 90.0},
                                       .heading_rad = 0.5,
                                       .length_m = 200.0,
                                       .width_m = 0.3,
                                       .gradient = 0.05,
                                       .curvature_1pm = 1.0 / 100.0}});
  const auto tiles = build_tiles(site);
  EXPECT_NEAR(plan_area_m2(find_mesh(tiles[0], MeshKind::road)), 60.0, 1.0);
  EXPECT_LT(worst_m(site, tiles), 0.02);
  expect_closed(tiles[0], on_tile_border);
}

TEST(RoadMesh, triangles_keep_to_lanes) {
  Site site = make_site(480.0, {{.start = {west_m + 60.0, south_m + 240.0}, .length_m = 300.0}});
  roadquery::Road& road = site.roads.roads[0];
  roadquery::Lane walk;
  walk.id = -2, walk.type = roadquery::LaneType::sidewalk, walk.width = {{.a = 1.5}};
  road.sections[0].right.push_back(walk);
  roadquery::LaneSection later = road.sections[0];
  later.s = 150.0;
  later.left.push_back({.id = 2, .type = roadquery::LaneType::parking, .width = {{.a = 2.0}}});
  road.sections.push_back(later);
  const auto tiles = build_tiles(site);
  const TriMesh& mesh = *find_mesh(tiles[0], MeshKind::road);
  std::map<std::string, double> area_m2;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const SceneFeature& lane = tiles[0].features.at(mesh.features[mesh.indices[i]]);
    const int id = std::stoi(lane.lane_id);
    const double low = id == 1 ? 0.0 : id == 2 ? 3.0 : id == -1 ? -3.0 : -4.5;
    const double high = id == 1 ? 3.0 : id == 2 ? 5.0 : id == -1 ? 0.0 : -3.0;
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) {
      c[k] = world(tiles[0], mesh.positions[mesh.indices[i + k]]);
      EXPECT_GE(c[k].y - south_m - 240.0, low - 2e-3) << lane.lane_id;
      EXPECT_LE(c[k].y - south_m - 240.0, high + 2e-3) << lane.lane_id;
    }
    area_m2[lane.lane_type] +=
        0.5 * cross(Vec2{c[1].x - c[0].x, c[1].y - c[0].y}, Vec2{c[2].x - c[0].x, c[2].y - c[0].y});
  }
  EXPECT_NEAR(area_m2["driving"], 300.0 * 6.0, 0.5);
  EXPECT_NEAR(area_m2["sidewalk"], 300.0 * 1.5, 0.5);
  EXPECT_NEAR(area_m2["parking"], 150.0 * 2.0, 0.5);
}

TEST(RoadMesh, roads_of_the_ground_that_lie_over_each_other_are_both_there) {
  // Two legs of a hairpin on a slope, 5 m apart and 6 m wide.
  const Site site = make_site(480.0, {{.start = {west_m + 60.0, south_m + 240.0}, .length_m = 200.0, .z_m = 10.0},
                                      {.start = {west_m + 60.0, south_m + 245.0}, .length_m = 200.0, .z_m = 16.0}});
  EXPECT_EQ(scene::lying_over(site.roads.roads), (std::vector<bool>{false, true}));
  const auto tiles = build_tiles(site);
  EXPECT_NEAR(plan_area_m2(find_mesh(tiles[0], MeshKind::road)), 2.0 * 200.0 * 6.0, 0.5);
  EXPECT_LT(worst_m(site, tiles), 0.02);
}

TEST(RoadMesh, roads_that_cross_on_one_level_do_not_lie_over_each_other) {
  const Site site = make_site(480.0, {{.start = {west_m + 60.0, south_m + 240.0}, .length_m = 200.0, .z_m = 10.0},
                                      {.start = {west_m + 100.0, south_m + 200.0}, .heading_rad = 1.5, .z_m = 11.0}});
  EXPECT_EQ(scene::lying_over(site.roads.roads), (std::vector<bool>{false, false}));
  EXPECT_TRUE(scene::lying_over({}).empty());
}

/// Bends most far from the edge that must not be split, which is straight.
double bowl_m(Vec2 p) { return 0.002 * (p.y + 8.0) * p.x * p.x + 0.01 * (p.y + 8.0) * (p.y + 8.0); }

/// A square of 16 m in one of 40 m, its edges constraints.
scene::Triangulation refined_bowl(bool reversed, double tolerance_m) {
  std::vector<Vec2> points = {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}, {-8, -8}, {8, -8}, {8, 8}, {-8, 8}};
  std::vector<std::array<std::uint32_t, 2>> constraints;
  for (const std::uint32_t first : {0U, 4U})
    for (std::uint32_t k = 0; k < 4; ++k) constraints.push_back({first + k, first + (k + 1) % 4});
  if (reversed) {
    std::ranges::reverse(points);
    for (auto& [a, b] : constraints) a = 7 - a, b = 7 - b;
    std::ranges::reverse(constraints);
  }
  return scene::triangulate(points, constraints,
                            {.is_kept = [](Vec2 p) { return std::max(std::abs(p.x), std::abs(p.y)) < 8.0; },
                             .height_m = [](Vec2 p) { return std::optional(bowl_m(p)); },
                             .may_split = [](Vec2 a, Vec2 b) { return !(a.y == -8.0 && b.y == -8.0); },
                             .tolerance_m = tolerance_m});
}

TEST(Triangulate, is_refined_where_a_surface_is_kept_and_nowhere_else) {
  const scene::Triangulation t = refined_bowl(false, 0.02);
  const auto z = bowl_m;
  EXPECT_GT(t.points.size(), 20U);
  EXPECT_LT(t.points.size(), 400U);
  double kept_m2 = 0.0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const Vec2 a = t.points[t.triangles[i][0]], b = t.points[t.triangles[i][1]], c = t.points[t.triangles[i][2]];
    const Vec2 middle = (a + b + c) * (1.0 / 3.0);
    EXPECT_GT(cross(b - a, c - a), 0.0);
    const Vec2 region = t.region_points[t.regions[i]];
    const bool kept = std::max(std::abs(region.x), std::abs(region.y)) < 8.0;
    EXPECT_EQ(kept, std::max(std::abs(middle.x), std::abs(middle.y)) < 8.0);
    if (!kept) continue;
    kept_m2 += 0.5 * cross(b - a, c - a);
    EXPECT_NEAR(z(middle), (z(a) + z(b) + z(c)) / 3.0, 0.021);
    for (const auto& [p, q] : {std::pair{a, b}, {b, c}, {c, a}})
      if (!(p.y == -8.0 && q.y == -8.0)) EXPECT_NEAR(z((p + q) * 0.5), 0.5 * (z(p) + z(q)), 0.021);
  }
  EXPECT_NEAR(kept_m2, 256.0, 0.05);
  for (const Vec2 p : t.points)  // the edge that others share, and the region around
    EXPECT_TRUE(p.y != -8.0 || std::abs(p.x) == 8.0);
}

TEST(Triangulate, refined_points_do_not_depend_on_the_order_of_those_given) {
  const auto sorted = [](const scene::Triangulation& t) {
    std::vector<std::pair<double, double>> points;
    for (const Vec2 p : t.points) points.push_back({p.x, p.y});
    std::ranges::sort(points);
    return points;
  };
  EXPECT_EQ(sorted(refined_bowl(false, 0.01)), sorted(refined_bowl(true, 0.01)));
}

TEST(Triangulate, a_step_does_not_refine_for_ever) {
  const std::vector<Vec2> points = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  const scene::Triangulation t =
      scene::triangulate(points, {},
                         {.is_kept = [](Vec2) { return true; },
                          .height_m = [](Vec2 p) { return std::optional(p.x + p.y > 9.3 ? 1.0 : 0.0); },
                          .may_split = [](Vec2, Vec2) { return true; }});
  EXPECT_LT(t.points.size(), 20000U);
}

}  // namespace
}  // namespace orthodrive
