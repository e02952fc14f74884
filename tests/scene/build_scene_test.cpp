// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <mutex>
#include <set>

#include "orthodrive/core/byte_archive.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/buildings/archived_tiles.hpp"
#include "sanitized.hpp"
#include "scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

SceneTile build_one(const Site& site, TileAddress address = {1000, 13000}, const SceneOptions& options = {}) {
  return build_scene_tile(*lay_out_scene(site.input(), options), address);
}

TEST(BuildScene, straight_road_on_flat_ground_fills_the_tile) {
  const Site site =
      make_site(480.0, {{.start = {west_m + 50.3, south_m + 60.7}, .heading_rad = 0.6, .length_m = 300.0}});
  const SceneTile tile = build_one(site);
  const TriMesh *terrain = find_mesh(tile, MeshKind::terrain), *road = find_mesh(tile, MeshKind::road);
  ASSERT_TRUE(terrain != nullptr && road != nullptr);
  EXPECT_NEAR((plan_area_m2(terrain) + plan_area_m2(road)) / (480.0 * 480.0), 1.0, 1e-9);
  EXPECT_NEAR(plan_area_m2(road), 300.0 * 6.0, 1.0);
  expect_upwards(*terrain);
  expect_upwards(*road);
  expect_closed(tile, on_tile_border);
  for (const auto& p : road->positions) EXPECT_NEAR(world(tile, p).z, 10.0, 1e-5);
  for (const auto& n : terrain->normals) EXPECT_NEAR(n[2], 1.0F, 1e-5F);
}

TEST(BuildScene, road_vertices_lie_on_the_surface_of_the_road) {
  const RoadShape shape{.start = {west_m + 100.0, south_m + 100.0},
                        .heading_rad = 0.3,
                        .length_m = 250.0,
                        .width_m = 7.0,
                        .z_m = 12.0,
                        .gradient = 0.05,
                        .curvature_1pm = 1.0 / 120.0,
                        .superelevation_rad = 0.06};
  const Site site = make_site(480.0, {shape});
  const SceneTile tile = build_one(site);
  const TriMesh* road = find_mesh(tile, MeshKind::road);
  ASSERT_NE(road, nullptr);
  // The arc's centre and radius give (s, t) of a point in closed form.
  const double radius = 120.0;
  const Vec2 center = shape.start + Vec2{-std::sin(0.3), std::cos(0.3)} * radius;
  for (const auto& p : road->positions) {
    const Vec3 q = world(tile, p);
    const Vec2 d = Vec2{q.x, q.y} - center;
    const double angle = std::atan2(d.y, d.x) - (0.3 - 0.5 * pi);
    const double s = std::clamp(std::remainder(angle, 2.0 * pi) * radius, 0.0, 250.0);
    const double across = radius - length(d);  // in plan, positive to the left
    EXPECT_NEAR(q.z, 12.0 + 0.05 * s + across * std::tan(0.06), 2e-3);
  }
  // The union's area equals the arc strip's, up to the chords' tolerance.
  EXPECT_NEAR(plan_area_m2(road), 250.0 * 7.0 * std::cos(0.06), 250.0 * 2.0 * 0.02);
}

TEST(BuildScene, road_triangles_stay_near_the_surface_between_their_vertices) {
  // A crest in a bend whose banking changes: nothing here is straight.
  Site site = make_site(480.0, {{.start = {west_m + 100.0, south_m + 150.0},
                                 .heading_rad = 0.1,
                                 .length_m = 250.0,
                                 .width_m = 8.0,
                                 .curvature_1pm = 1.0 / 150.0}});
  roadquery::Road& road = site.roads.roads[0];
  road.elevation = {{.a = 12.0, .b = 0.06, .c = -4e-4}};
  road.superelevation = {{.b = 0.08 / 250.0}};
  const SceneTile tile = build_one(site);
  for (double s = 0.5; s < 250.0; s += 3.7) {
    for (const double t : {-3.8, -1.3, 0.0, 2.1, 3.8}) {
      const auto at = roadquery::surface_point(road, s, t);
      EXPECT_NEAR(mesh_height_m(tile, *find_mesh(tile, MeshKind::road), {at.x, at.y}), at.z, 0.03) << s << ' ' << t;
    }
  }
}

TEST(BuildScene, sidewalks_and_shoulders_are_meshed_on_the_same_surface) {
  Site site = make_site(
      480.0,
      {{.start = {west_m + 60.0, south_m + 90.0}, .heading_rad = 0.5, .length_m = 200.0, .superelevation_rad = 0.03}});
  roadquery::Road& road = site.roads.roads[0];
  const auto lane = [](int id, roadquery::LaneType type, double width_m) {
    roadquery::Lane made;
    made.id = id, made.type = type, made.width = {{.a = width_m}};
    return made;
  };
  road.sections[0].right.push_back(lane(-2, roadquery::LaneType::shoulder, 1.0));
  road.sections[0].right.push_back(lane(-3, roadquery::LaneType::sidewalk, 2.0));
  // The sidewalk on the other side begins half way.
  roadquery::LaneSection later = road.sections[0];
  later.s = 100.0;
  later.left.push_back(lane(2, roadquery::LaneType::sidewalk, 2.0));
  road.sections.push_back(later);
  const SceneTile tile = build_one(site);
  const TriMesh& mesh = *find_mesh(tile, MeshKind::road);
  EXPECT_NEAR(plan_area_m2(&mesh), (200.0 * 9.0 + 100.0 * 2.0) * std::cos(0.03), 1.0);
  for (double s = 1.0; s < 200.0; s += 7.3)
    for (const double t : {-5.9, -4.5, -3.5, 0.0, 2.9, 4.9}) {
      const auto at = roadquery::surface_point(road, s, t);
      const double z = mesh_height_m(tile, mesh, {at.x, at.y});
      if (t > 3.0 && s < 100.0)
        EXPECT_TRUE(std::isnan(z)) << s << ' ' << t;
      else
        EXPECT_NEAR(z, at.z, 0.02) << s << ' ' << t;
    }
}

TEST(BuildScene, crown_has_its_ridge_on_the_reference_line) {
  // Straight and level: sections stand 10 m apart, and without edges along the middle triangles would cut the roof off,
  // by 3 m * 5 % where they go from edge to edge.
  Site site = make_site(480.0, {{.start = {west_m + 60.0, south_m + 90.0}, .heading_rad = 0.5, .length_m = 200.0},
                                {.start = {west_m + 100.0, south_m + 300.0},
                                 .heading_rad = 0.1,
                                 .length_m = 200.0,
                                 .curvature_1pm = 1.0 / 90.0,
                                 .superelevation_rad = 0.03}});
  for (roadquery::Road& road : site.roads.roads)
    for (const double s : {0.0, 120.0, 160.0}) {
      const double fall = s < 150.0 ? 0.05 : 0.01;
      road.shape.push_back({s, -30.0, -30.0 * fall, fall, 0.0, 0.0});
      road.shape.push_back({s, 0.0, 0.0, -fall, 0.0, 0.0});
    }
  const SceneTile tile = build_one(site);
  for (const roadquery::Road& road : site.roads.roads)
    for (double s = 0.05; s < 200.0; s += 1.9)
      for (const double t : {-2.6, -1.0, 0.0, 1.0, 2.6}) {
        const auto at = roadquery::surface_point(road, s, t);
        EXPECT_NEAR(mesh_height_m(tile, *find_mesh(tile, MeshKind::road), {at.x, at.y}), at.z, 0.02) << s << ' ' << t;
      }
}

TEST(BuildScene, crowned_roads_keep_their_shape_across_tile_borders) {
  // Askew, so that the border of the tiles cuts the roof at no section of the road.
  Site site = make_site(
      960.0, {{.start = {west_m + 380.0, south_m + 150.0}, .heading_rad = 0.6, .length_m = 260.0, .width_m = 9.0},
              {.start = {west_m + 90.0, south_m + 560.0}, .heading_rad = -1.1, .length_m = 200.0, .width_m = 7.0}});
  for (roadquery::Road& road : site.roads.roads) {
    road.shape.push_back({0.0, -30.0, -30.0 * 0.05, 0.05, 0.0, 0.0});
    road.shape.push_back({0.0, 0.0, 0.0, -0.05, 0.0, 0.0});
  }
  const auto layout = lay_out_scene(site.input());
  int crossings = 0;
  for (const TileAddress address : scene_tiles(*layout)) {
    const SceneTile tile = build_scene_tile(*layout, address);
    const TriMesh* mesh = find_mesh(tile, MeshKind::road);
    if (mesh == nullptr) continue;
    for (const roadquery::Road& road : site.roads.roads)
      for (double s = 0.05; s < road.length; s += 0.7)
        for (const double t : {-2.6, -1.3, 0.0, 1.3, 2.6}) {
          const auto at = roadquery::surface_point(road, s, t);
          const double east_m = std::abs(at.x - west_m - 480.0), north_m = std::abs(at.y - south_m - 480.0);
          const Box2 box{tile.origin.x - 240.0, tile.origin.y - 240.0, tile.origin.x + 240.0, tile.origin.y + 240.0};
          if (std::min(east_m, north_m) > 5.0 || !box.contains({at.x, at.y})) continue;
          ++crossings;
          EXPECT_NEAR(mesh_height_m(tile, *mesh, {at.x, at.y}), at.z, 0.02) << s << ' ' << t;
        }
  }
  EXPECT_GT(crossings, 100);
}

TEST(BuildScene, ground_meets_the_road_and_becomes_terrain_within_the_verge) {
  // A road 3 m above a plain, as a bad DTM would have it.
  const Site site = make_site(480.0, {{.start = {west_m + 20.0, south_m + 200.0}, .length_m = 400.0, .z_m = 13.0}});
  const SceneTile tile = build_one(site, {1000, 13000}, {.verge_m = 5.0});
  const TriMesh* terrain = find_mesh(tile, MeshKind::terrain);
  ASSERT_NE(terrain, nullptr);
  double highest = 0.0;
  for (const auto& p : terrain->positions) {
    const Vec3 q = world(tile, p);
    const double dx = std::max({0.0, west_m + 20.0 - q.x, q.x - (west_m + 420.0)});
    const double beside = std::hypot(dx, std::max(0.0, std::abs(q.y - (south_m + 200.0)) - 3.0));
    if (beside >= 5.0 || beside < 1e-6) {
      EXPECT_NEAR(q.z, beside < 1e-6 ? 13.0 : 10.0, 1e-5);
    }
    EXPECT_GT(q.z, 10.0 - 1e-5);
    highest = std::max(highest, q.z);
  }
  EXPECT_NEAR(highest, 13.0, 1e-5);
  expect_closed(tile, on_tile_border);
}

TEST(BuildScene, neighbours_share_the_vertices_of_their_border_bit_by_bit) {
  const auto hills = [](Vec2 p) { return 20.0 + 8.0 * std::sin(p.x / 37.0) + 5.0 * std::cos(p.y / 23.0); };
  const Site site = make_site(960.0,
                              {{.start = {west_m + 300.0, south_m + 100.3},
                                .heading_rad = 0.2,
                                .length_m = 500.0,
                                .z_m = 20.0,
                                .gradient = 0.02},
                               {.start = {west_m + 470.0, south_m + 300.0},
                                .heading_rad = 0.5 * pi,
                                .length_m = 400.0,
                                .width_m = 20.0,
                                .z_m = 22.0},
                               {.start = {west_m + 483.0, south_m + 20.0},
                                .heading_rad = 0.5 * pi,
                                .length_m = 60.0,
                                .z_m = 21.0}},  // edge on it
                              hills);
  const auto layout = lay_out_scene(site.input());
  ASSERT_EQ(scene_tiles(*layout).size(), 4U);
  std::map<TileAddress, SceneTile> tiles;
  for (const TileAddress a : scene_tiles(*layout)) tiles[a] = build_scene_tile(*layout, a);
  using Point = std::array<double, 3>;
  const auto on_line = [&](const SceneTile& tile, bool vertical, double at, MeshKind kind) {
    std::set<Point> points;
    if (const TriMesh* mesh = find_mesh(tile, kind))
      for (const auto& p : mesh->positions)
        if (const Vec3 q = world(tile, p); (vertical ? q.x : q.y) == at) points.insert({q.x, q.y, q.z});
    return points;
  };
  const auto both = [&](const SceneTile& tile, bool vertical, double at) {
    auto points = on_line(tile, vertical, at, MeshKind::terrain);
    points.merge(on_line(tile, vertical, at, MeshKind::road));
    return points;
  };
  for (const int k : {13000, 13001}) {
    const auto left = both(tiles[{1000, k}], true, west_m + 480.0),
               right = both(tiles[{1001, k}], true, west_m + 480.0);
    EXPECT_GT(left.size(), 40U);
    EXPECT_EQ(left, right);
  }
  for (const int c : {1000, 1001}) {
    const auto below = both(tiles[{c, 13000}], false, south_m + 480.0),
               above = both(tiles[{c, 13001}], false, south_m + 480.0);
    EXPECT_GT(below.size(), 40U);
    EXPECT_EQ(below, above);
  }
  // The road that crosses the border is cut there: its vertices on the line are those of the other tile's road.
  EXPECT_GE(on_line(tiles[{1000, 13000}], true, west_m + 480.0, MeshKind::road).size(), 2U);
  double area = 0.0;
  for (const auto& [address, tile] : tiles) {
    area += plan_area_m2(find_mesh(tile, MeshKind::terrain)) + plan_area_m2(find_mesh(tile, MeshKind::road));
    expect_closed(tile, on_tile_border);
  }
  EXPECT_NEAR(area / (960.0 * 960.0), 1.0, 1e-9);
}

TEST(BuildScene, overlapping_roads_become_one_surface) {
  // A crossing, the same road twice, and two roads side by side whose edges miss each other by a millimetre or two.
  const Site site =
      make_site(480.0, {{.start = {west_m + 100.0, south_m + 200.0}, .length_m = 200.0},
                        {.start = {west_m + 200.0, south_m + 100.0}, .heading_rad = 0.5 * pi, .length_m = 200.0},
                        {.start = {west_m + 100.0, south_m + 200.0}, .length_m = 200.0},
                        {.start = {west_m + 100.0, south_m + 206.0015}, .heading_rad = 1e-5, .length_m = 200.0},
                        {.start = {west_m + 100.0, south_m + 205.9}, .heading_rad = 1e-3, .length_m = 200.0}});
  const SceneTile tile = build_one(site);
  const TriMesh* road = find_mesh(tile, MeshKind::road);
  ASSERT_NE(road, nullptr);
  EXPECT_NEAR(plan_area_m2(road), 200.0 * 12.0 + 200.0 * 6.0 - 12.0 * 6.0, 25.0);
  EXPECT_NEAR((plan_area_m2(find_mesh(tile, MeshKind::terrain)) + plan_area_m2(road)) / (480.0 * 480.0), 1.0, 1e-9);
  expect_upwards(*road);
  expect_upwards(*find_mesh(tile, MeshKind::terrain));
  expect_closed(tile, on_tile_border);
  for (const auto& p : road->positions) EXPECT_NEAR(world(tile, p).z, 10.0, 1e-5);
}

TEST(BuildScene, crossing_roads_blend_between_their_heights) {
  const Site site = make_site(
      480.0, {{.start = {west_m + 100.0, south_m + 200.0}, .length_m = 200.0, .z_m = 10.0},
              {.start = {west_m + 200.0, south_m + 100.0}, .heading_rad = 0.5 * pi, .length_m = 200.0, .z_m = 10.4}});
  const SceneTile tile = build_one(site);
  for (const auto& p : find_mesh(tile, MeshKind::road)->positions) {
    const Vec3 q = world(tile, p);
    const bool on_first = std::abs(q.y - south_m - 200.0) < 3.001, on_second = std::abs(q.x - west_m - 200.0) < 3.001;
    if (on_first != on_second) {
      EXPECT_NEAR(q.z, on_first ? 10.0 : 10.4, 1e-5);
    }
    EXPECT_GE(q.z, 10.0 - 1e-5);
    EXPECT_LE(q.z, 10.4 + 1e-5);
  }
}

TEST(BuildScene, bridge_deck_stays_above_the_terrain_and_does_not_cut_it) {
  // A bridge over a valley with a road in it; the DTM runs through the deck on the banks.
  const auto valley = [](Vec2 p) { return 10.0 + 0.15 * std::abs(p.x - west_m - 240.0); };
  const Site site = make_site(
      480.0,
      {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 140.0, .z_m = 19.0},
       {.start = {west_m + 180.0, south_m + 240.0}, .length_m = 120.0, .z_m = 19.0, .layer = 1, .bridge = true},
       {.start = {west_m + 300.0, south_m + 240.0}, .length_m = 140.0, .z_m = 19.0},
       {.start = {west_m + 240.0, south_m + 40.0}, .heading_rad = 0.5 * pi, .length_m = 400.0, .z_m = 10.0}},
      valley);
  const SceneTile tile = build_one(site);
  const TriMesh *terrain = find_mesh(tile, MeshKind::terrain), *bridge = find_mesh(tile, MeshKind::road_body);
  ASSERT_TRUE(terrain != nullptr && bridge != nullptr);
  const double ground_roads_m2 = 2.0 * 140.0 * 6.0 + 400.0 * 6.0, deck_m2 = 120.0 * 6.0;
  EXPECT_NEAR(plan_area_m2(terrain), 480.0 * 480.0 - ground_roads_m2, 1.0);
  EXPECT_NEAR(plan_area_m2(find_mesh(tile, MeshKind::road)), ground_roads_m2 + deck_m2, 1.0);
  int below = 0;
  for (const auto& p : terrain->positions) {
    const Vec3 q = world(tile, p);
    if (q.x < west_m + 181.0 || q.x > west_m + 299.0 || std::abs(q.y - south_m - 240.0) > 3.0) continue;
    EXPECT_LT(q.z, 19.0 - 0.05);
    ++below;
  }
  EXPECT_GT(below, 20);
  for (const auto& p : bridge->positions) {
    const double z = world(tile, p).z;
    EXPECT_TRUE(std::abs(z - 19.0) < 1e-5 || std::abs(z - 18.2) < 1e-5) << z;
  }
}

TEST(BuildScene, corners_of_a_junction_far_from_its_roads_have_its_height) {
  // The corners of the paved square lie 7 m beside the only road, and off the plan grid.
  Site site = make_site(480.0, {{.start = {west_m + 230.0, south_m + 240.0}, .length_m = 20.0}});
  site.roads.roads[0].junction = 7;
  roadquery::JunctionSurface surface{.x = west_m + 228.0, .y = south_m + 228.0, .columns = 25, .rows = 25};
  surface.z.assign(25U * 25U, 10.0);
  for (const auto& [x, y] :
       {std::pair{230.0001, 230.0002}, {250.0003, 230.0004}, {250.0001, 250.0003}, {230.0002, 250.0001}})
    surface.boundary.push_back({west_m + x, south_m + y});
  site.roads.junctions.push_back({.id = 7, .surface = surface});
  const SceneTile tile = build_one(site);
  const TriMesh* road = find_mesh(tile, MeshKind::road);
  ASSERT_NE(road, nullptr);
  EXPECT_NEAR(plan_area_m2(road), 400.0, 0.1);
  for (const MeshKind kind : {MeshKind::road, MeshKind::terrain})
    for (const auto& p : find_mesh(tile, kind)->positions) EXPECT_NEAR(world(tile, p).z, 10.0, 1e-5);
}

TEST(BuildScene, every_triangle_of_roads_and_buildings_says_what_it_is) {
  Site site = make_site(480.0, {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 140.0},
                                {.start = {west_m + 180.0, south_m + 240.0}, .length_m = 140.0}});
  site.roads.roads[0].osm_id = "17", site.roads.roads[0].name = "Hauptstraße";
  const std::vector<Building> houses = {
      {.footprint = {square(west_m + 100.0, south_m + 100.0, 12.0), {}}, .use = "house", .osm_id = "way/5"},
      {.footprint = {square(west_m + 200.0, south_m + 100.0, 20.0), {}}, .use = "barn"}};
  SceneInput input = site.input();
  input.buildings = houses;
  const SceneTile tile = build_scene_tile(*lay_out_scene(input), {1000, 13000});
  const TriMesh &road = *find_mesh(tile, MeshKind::road), &building = *find_mesh(tile, MeshKind::building);
  ASSERT_EQ(road.features.size(), road.positions.size());
  ASSERT_EQ(building.features.size(), building.positions.size());
  const auto each = [&](const TriMesh& mesh, const auto& check) {
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      Vec3 middle;
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(mesh.features[mesh.indices[i]], mesh.features[mesh.indices[i + k]]);
        middle = middle + world(tile, mesh.positions[mesh.indices[i + k]]) * (1.0 / 3.0);
      }
      check(tile.features.at(mesh.features[mesh.indices[i]]), middle);
    }
  };
  each(road, [&](const SceneFeature& feature, Vec3 middle) {
    EXPECT_EQ(feature.kind, "road");
    const bool first = middle.x < west_m + 180.0;
    EXPECT_EQ(feature.id, first ? "1" : "2");
    EXPECT_EQ(feature.osm_id, first ? "way/17" : "");
    EXPECT_EQ(feature.name, first ? "Hauptstraße" : "");
    EXPECT_EQ(feature.lane_id, middle.y > south_m + 240.0 ? "1" : "-1");
    EXPECT_EQ(feature.lane_type, "driving");
  });
  each(building, [&](const SceneFeature& feature, Vec3 middle) {
    EXPECT_EQ(feature.kind, "building");
    EXPECT_EQ(feature.type, middle.x < west_m + 150.0 ? "house" : "barn");
    EXPECT_EQ(feature.osm_id, middle.x < west_m + 150.0 ? "way/5" : "");
  });
}

TEST(BuildScene, tunnels_leave_the_ground_alone) {
  const Site site = make_site(
      480.0,
      {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 140.0, .z_m = -5.0, .layer = -1, .tunnel = true}});
  const SceneTile tile = build_one(site);
  EXPECT_EQ(find_mesh(tile, MeshKind::road), nullptr);
  EXPECT_NEAR(plan_area_m2(find_mesh(tile, MeshKind::terrain)), 480.0 * 480.0, 1e-6);
}

TEST(BuildScene, scene_ends_at_a_slanted_area) {
  Site site = make_site(480.0, {{.start = {west_m - 100.0, south_m + 240.0}, .length_m = 900.0}});
  site.area.outer = {{west_m + 30.0, south_m + 20.0},
                     {west_m + 440.0, south_m + 60.0},
                     {west_m + 420.0, south_m + 450.0},
                     {west_m + 10.0, south_m + 400.0}};
  const SceneTile tile = build_one(site);
  EXPECT_NEAR(plan_area_m2(find_mesh(tile, MeshKind::terrain)) + plan_area_m2(find_mesh(tile, MeshKind::road)),
              area_m2(site.area), 0.5);
  expect_closed(tile, [&](Vec2 a, Vec2 b) {
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 p = site.area.outer[i], d = normalized(site.area.outer[(i + 1) % 4] - p);
      if (std::abs(cross(d, a - p)) < 2e-3 && std::abs(cross(d, b - p)) < 2e-3) return true;
    }
    return false;
  });
}

TEST(BuildScene, outline_of_a_photo_is_around_its_valid_pixels) {
  Photo photo = make_site(480.0, {}).photo;
  for (int row = 0; row < 480; ++row)
    for (int col = 0; col < row; ++col) photo.valid.at(col, row) = 0;  // the half below the diagonal is missing
  const Polygon outline = photo_outline(source_of(photo));
  EXPECT_NEAR(area_m2(outline), 0.5 * 480.0 * 480.0 + 480.0, 500.0);
  EXPECT_TRUE(contains(outline, {west_m + 300.0, south_m + 300.0}));
  EXPECT_FALSE(contains(outline, {west_m + 100.0, south_m + 100.0}));
  std::fill(photo.valid.data.begin(), photo.valid.data.end(), 0);
  EXPECT_TRUE(photo_outline(source_of(photo)).outer.empty());
}

TEST(BuildScene, tile_outside_the_area_is_empty) {
  const Site site = make_site(480.0, {{.start = {west_m + 10.0, south_m + 10.0}}});
  const auto layout = lay_out_scene(site.input());
  EXPECT_EQ(scene_tiles(*layout), (std::vector<TileAddress>{{1000, 13000}}));
  const SceneTile tile = build_scene_tile(*layout, {1002, 13000});
  EXPECT_TRUE(tile.meshes.empty());
  EXPECT_TRUE(tile.texture_rgb.empty());
}

TEST(BuildScene, no_roads_at_all_is_plain_terrain) {
  const SceneTile tile = build_one(make_site(480.0, {}));
  EXPECT_EQ(find_mesh(tile, MeshKind::road), nullptr);
  EXPECT_NEAR(plan_area_m2(find_mesh(tile, MeshKind::terrain)), 480.0 * 480.0, 1e-6);
  expect_closed(tile, on_tile_border);
}

TEST(BuildScene, terrain_points_stand_on_a_disturbed_raster_of_10_m) {
  const SceneTile tile = build_one(make_site(480.0, {}));
  std::set<std::pair<int, int>> cells;
  double moved_m = 0.0;
  int inside = 0;
  for (const auto& p : find_mesh(tile, MeshKind::terrain)->positions) {
    const Vec3 q = world(tile, p);
    const double x = q.x - west_m, y = q.y - south_m;
    if (std::min({x, y, 480.0 - x, 480.0 - y}) < 0.01) continue;  // on the border, which neighbours share
    const int column = static_cast<int>(x / 10.0), row = static_cast<int>(y / 10.0);
    const double dx = x - 10.0 * column - 5.0, dy = y - 10.0 * row - 5.0;
    EXPECT_LE(std::max(std::abs(dx), std::abs(dy)), 3.01) << x << ' ' << y;
    moved_m += std::hypot(dx, dy);
    cells.insert({column, row});
    ++inside;
  }
  EXPECT_EQ(inside, 48 * 48);
  EXPECT_EQ(cells.size(), 48U * 48U) << "one in every cell";
  EXPECT_GT(moved_m / inside, 1.0);
}

TEST(BuildScene, holes_of_the_terrain_are_filled_and_found) {
  Site site = make_site(480.0, {}, [](Vec2 p) { return 30.0 + 0.1 * (p.x - west_m); });
  for (int row = 20; row < 30; ++row)
    for (int col = 40; col < 52; ++col) site.terrain.height_m.at(col, row) = std::nanf("");
  const auto layout = lay_out_scene(site.input());
  ASSERT_EQ(scene_findings(*layout).size(), 1U);
  EXPECT_EQ(scene_findings(*layout)[0].code, "scene.terrain_hole");
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  for (const auto& p : find_mesh(tile, MeshKind::terrain)->positions) {
    const Vec3 q = world(tile, p);
    ASSERT_TRUE(std::isfinite(q.z));
    EXPECT_NEAR(q.z, 30.0 + 0.1 * (q.x - west_m), 3.0);  // as coarse as the hole is wide (60 m, 6 m of rise)
  }
}

TEST(BuildScene, no_height_no_step_no_area_are_errors) {
  Site site = make_site(480.0, {});
  for (float& z : site.terrain.height_m.data) z = std::nanf("");
  EXPECT_THROW((void)lay_out_scene(site.input()), InputError);
  site = make_site(480.0, {});
  EXPECT_THROW((void)lay_out_scene(site.input(), {.terrain_step_m = 0.0}), OptionError);
  site.area = {};
  EXPECT_THROW((void)lay_out_scene(site.input()), OptionError);
}

TEST(BuildScene, road_without_heights_is_left_out_and_found) {
  const Site site = make_site(480.0, {{.start = {west_m + 10.0, south_m + 10.0}, .z_m = std::nan("")}});
  const auto layout = lay_out_scene(site.input());
  ASSERT_EQ(scene_findings(*layout).size(), 1U);
  EXPECT_EQ(scene_findings(*layout)[0].code, "scene.road_without_surface");
  EXPECT_EQ(find_mesh(build_scene_tile(*layout, {1000, 13000}), MeshKind::road), nullptr);
}

TEST(BuildScene, bend_tighter_than_the_road_is_wide_stays_a_surface) {
  const Site site = make_site(
      480.0,
      {{.start = {west_m + 200.0, south_m + 200.0}, .length_m = 15.0, .width_m = 12.0, .curvature_1pm = 1.0 / 4.0}});
  const SceneTile tile = build_one(site);
  expect_upwards(*find_mesh(tile, MeshKind::road));
  expect_closed(tile, on_tile_border);
  for (const auto& p : find_mesh(tile, MeshKind::road)->positions) EXPECT_NEAR(world(tile, p).z, 10.0, 1e-5);
}

TEST(BuildScene, texture_has_the_photo_at_its_place) {
  Site site = make_site(480.0, {});
  for (int row = 0; row < 480; ++row)
    for (int col = 0; col < 480; ++col) {
      site.photo.rgb.at(col, row, 0) = static_cast<std::uint8_t>(col / 2);
      site.photo.rgb.at(col, row, 1) = static_cast<std::uint8_t>(row / 2);
    }
  for (int row = 0; row < 100; ++row) site.photo.valid.at(7, row) = 0;
  const Raster<std::uint8_t> native = build_one(site).texture_rgb;
  ASSERT_EQ(native.width, 480);
  EXPECT_EQ(native.at(300, 120, 0), 150);
  EXPECT_EQ(native.at(300, 120, 1), 60);
  EXPECT_NEAR(native.at(7, 50, 0), 3, 1);  // no photo there: from its neighbours
  const Raster<std::uint8_t> half = build_one(site, {1000, 13000}, {.max_texture_px = 240}).texture_rgb;
  ASSERT_EQ(half.width, 240);
  EXPECT_NEAR(half.at(150, 60, 0), 150, 1);
}

TEST(BuildScene, texture_of_a_fine_photo_has_2048_pixels) {
  Site site = make_site(480.0, {});
  site.photo.frame = covering_grid({west_m, south_m, west_m + 480.0, south_m + 480.0}, 0.2);
  site.photo.rgb = Raster<std::uint8_t>(2400, 2400, 3, 90);
  site.photo.valid = Raster<std::uint8_t>(2400, 2400, 1, 1);
  const SceneTile tile = build_one(site);
  EXPECT_EQ(tile.texture_rgb.width, 2048);
  EXPECT_EQ(tile.texture_rgb.height, 2048);
}

TEST(BuildScene, labels_of_the_tile_are_those_of_the_map) {
  const Site site = make_site(480.0, {});
  LabelMap labels;
  labels.frame = {west_m, south_m + 480.0, 2.0, 200, 240};  // 80 m in the east are missing
  labels.labels = Raster<std::uint8_t>(200, 240, 1, 0);
  labels.labels.at(30, 10) = 6;
  labels.classes = default_class_table();
  SceneInput input = site.input();
  input.labels = &labels;
  const SceneTile tile = build_scene_tile(*lay_out_scene(input), {1000, 13000});
  ASSERT_EQ(tile.labels.width, 240);
  EXPECT_EQ(tile.labels.at(30, 10), 6);
  EXPECT_EQ(tile.labels.at(31, 10), 0);
  EXPECT_EQ(tile.labels.at(200, 10), label_nodata);
  EXPECT_EQ(tile.classes.classes.size(), labels.classes.classes.size());
}

TEST(BuildScene, paint_lies_on_the_road_and_crosses_tile_borders) {
  Site site = make_site(960.0, {{.start = {west_m + 400.0, south_m + 240.0}, .length_m = 160.0, .gradient = 0.05}});
  site.roads.roads[0].sections[0].center.marks = {{0.0, "solid", 0.2}};
  const auto layout = lay_out_scene(site.input());
  double area = 0.0;
  for (const TileAddress address : {TileAddress{1000, 13000}, TileAddress{1001, 13000}}) {
    const SceneTile tile = build_scene_tile(*layout, address);
    const TriMesh* marking = find_mesh(tile, MeshKind::marking);
    ASSERT_NE(marking, nullptr);
    area += plan_area_m2(marking);
    for (const auto& p : marking->positions) {
      const Vec3 at = world(tile, p);
      EXPECT_NEAR(at.z, 10.0 + 0.05 * (at.x - west_m - 400.0) + 0.006, 2e-4);
    }
    ASSERT_EQ(marking->parts.size(), 1U);
    EXPECT_EQ(marking->parts[0].material, SurfaceMaterial::paint);
  }
  EXPECT_NEAR(area, 160.0 * 0.2, 1e-3);
}

TEST(BuildScene, road_has_the_material_of_its_lanes_and_the_photos_tint) {
  Site site = make_site(480.0, {{.start = {west_m + 100.0, south_m + 240.0}, .length_m = 200.0}});
  for (auto* side : {&site.roads.roads[0].sections[0].left, &site.roads.roads[0].sections[0].right})
    side->front().materials = {{0.0, roadquery::SurfaceClass::asphalt}, {100.0, roadquery::SurfaceClass::setts}};
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), {1000, 13000});
  const TriMesh* road = find_mesh(tile, MeshKind::road);
  ASSERT_NE(road, nullptr);
  ASSERT_EQ(road->parts.size(), 2U);
  EXPECT_EQ(road->parts[0].material, SurfaceMaterial::setts);
  EXPECT_EQ(road->parts[1].material, SurfaceMaterial::lane);
  EXPECT_EQ(road->parts[1].first_index, road->parts[0].index_count);
  EXPECT_EQ(road->parts[1].first_index + road->parts[1].index_count, road->indices.size());
  for (const MeshPart& part : road->parts) {
    for (std::size_t i = part.first_index; i < part.first_index + part.index_count; i += 3) {
      double x = 0.0;
      for (std::size_t k = 0; k < 3; ++k) x += world(tile, road->positions[road->indices[i + k]]).x / 3.0;
      EXPECT_EQ(x > west_m + 200.0, part.material == SurfaceMaterial::setts) << x;
    }
  }
  // The photo is grey 90, linear 0.1022; textures have a mean of 0.6.
  for (const auto& color : road->colors) EXPECT_NEAR(color[1] / 65535.0 * 0.6, 0.1022, 1e-3);
  // Setts go on from tile to tile: the texture's sides divide a tile's. Asphalt follows the lanes, 3 m wide.
  for (const MeshPart& part : road->parts) {
    for (std::size_t k = part.first_index; k < part.first_index + part.index_count; ++k) {
      const std::uint32_t i = road->indices[k], first = road->indices[k - k % 3];
      const auto &uv = road->tile_uv[i], &from = road->tile_uv[first];
      const Vec3 p = world(tile, road->positions[i]), q = world(tile, road->positions[first]);
      if (part.material == SurfaceMaterial::setts) {
        EXPECT_NEAR(uv[0] * 4.0, road->positions[i][0], 1e-4);
        continue;
      }
      const bool left = tile.features[road->features[i]].lane_id == "1";
      EXPECT_NEAR(uv[0], ((left ? 3.0 : 0.0) - (p.y - south_m - 240.0)) / 3.0, 1e-3);
      EXPECT_NEAR(uv[1] - from[1], -(p.x - q.x) / 14.0, 1e-4);
    }
  }
}

TEST(BuildScene, verge_lies_on_the_terrain_and_fades_away_from_the_road) {
  const Site site = make_site(480.0, {{.start = {west_m + 100.0, south_m + 240.0}, .length_m = 200.0}});
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), {1000, 13000});
  const TriMesh *verge = find_mesh(tile, MeshKind::verge), *terrain = find_mesh(tile, MeshKind::terrain);
  ASSERT_NE(verge, nullptr);
  const std::set<std::array<float, 3>> ground(terrain->positions.begin(), terrain->positions.end());
  for (std::size_t i = 0; i < verge->positions.size(); ++i) {
    EXPECT_TRUE(ground.contains(verge->positions[i]));
    const Vec3 at = world(tile, verge->positions[i]);
    const double beside =
        std::max({std::abs(at.y - south_m - 240.0) - 3.0, west_m + 100.0 - at.x, at.x - west_m - 300.0});
    EXPECT_EQ(verge->colors[i][3], beside < 0.01 ? 65535 : 0) << beside;
  }
}

/// Roads of all kinds, bridges, buildings of map and labels, trees, barriers, a railway, lamps and water on hills, all
/// across the borders of four tiles.
struct FullSite {
  Site site;
  LabelMap labels;
  std::vector<Building> buildings;
  std::vector<Vec2> trees;
  MapSurroundings surroundings;

  FullSite() {
    const auto hills = [](Vec2 p) { return 20.0 + 3.0 * std::sin(p.x / 41.0) * std::cos(p.y / 29.0); };
    std::vector<RoadShape> shapes;
    shapes.reserve(12);
    for (int i = 0; i < 12; ++i)
      shapes.push_back({.start = {west_m + 60.0 * i, south_m + 40.0 * i},
                        .heading_rad = 0.5 * i,
                        .length_m = 300.0,
                        .z_m = 20.0,
                        .curvature_1pm = 0.002 * (i - 5),
                        .bridge = i % 4 == 0,
                        .tunnel = i % 4 == 2});
    site = make_site(960.0, shapes, hills);
    for (int row = 95; row < 103; ++row)  // holes of the terrain, at the corner of the tiles
      for (int col = 90; col < 110; ++col) site.terrain.height_m.at(col, row) = std::nanf("");
    for (std::size_t i = 0; i < site.photo.rgb.data.size(); ++i)
      site.photo.rgb.data[i] = static_cast<std::uint8_t>(splitmix64(i) % 200);
    labels = {{}, site.photo.frame, Raster<std::uint8_t>(960, 960), {}};
    labels.classes.classes = {{.name = "grass", .role = Role::other},
                              {.name = "tree", .role = Role::vegetation},
                              {.name = "building", .role = Role::building}};
    for (int row = 0; row < 960; ++row)
      for (int col = 0; col < 960; ++col)
        labels.labels.at(col, row) = (col / 30 + row / 50) % 4 == 0 ? 1 : (col % 120 < 25 && row % 110 < 35 ? 2 : 0);
    for (int i = 0; i < 40; ++i)
      buildings.push_back({.footprint = {square(west_m + 24.0 * i, south_m + 471.0 - 3.0 * i, 15.0), {}}});
    for (int i = 0; i < 60; ++i) trees.push_back({west_m + 16.0 * i, south_m + 700.0 - 8.0 * i});
    surroundings.barriers = {{BarrierKind::hedge, {{west_m + 20.0, south_m + 900.0}, {west_m + 900.0, south_m + 30.0}}},
                             {BarrierKind::wall, {{west_m + 30.0, south_m + 20.0}, {west_m + 940.0, south_m + 800.0}}}};
    surroundings.tracks = {{{west_m + 5.0, south_m + 530.0}, {west_m + 955.0, south_m + 610.0}}};
    surroundings.water = {{square(west_m + 400.0, south_m + 420.0, 130.0), {}}};
    for (int i = 0; i < 30; ++i) surroundings.lamps.push_back({west_m + 32.0 * i, south_m + 485.0 + i});
    for (int i = 0; i < 240; ++i)
      surroundings.objects.push_back({static_cast<ObjectKind>(i % 24), {west_m + 4.0 * i, south_m + 475.0 + i % 11}});
    surroundings.power_lines = {{{{west_m + 30.0, south_m + 50.0}, {west_m + 930.0, south_m + 880.0}}},
                                {{{west_m + 300.0, south_m + 900.0}, {west_m + 470.0, south_m + 470.0}}, true}};
  }
  [[nodiscard]] SceneInput input() const {
    SceneInput input = site.input();
    input.labels = &labels, input.buildings = buildings, input.trees = trees, input.surroundings = &surroundings;
    return input;
  }
};

std::map<TileAddress, SceneTile> build_all(const FullSite& site, const SceneOptions& options, SceneResult& result) {
  std::map<TileAddress, SceneTile> tiles;
  std::mutex mutex;
  result = build_scene(
      source_of(site.input()),
      [&](const SceneTile& tile) {
        const std::lock_guard lock(mutex);
        if (tile.level == 0) tiles[{tile.column, tile.row}] = tile;
      },
      options);
  return tiles;
}

void expect_same(const TriMesh& mesh, const TriMesh& other) {
  EXPECT_EQ(mesh.kind, other.kind);
  EXPECT_EQ(mesh.positions.size(), other.positions.size()) << to_string(mesh.kind);
  for (std::size_t i = 0, n = 0; i < std::min(mesh.positions.size(), other.positions.size()) && n < 4; ++i)
    if (mesh.positions[i] != other.positions[i]) {
      ++n;
      ADD_FAILURE() << to_string(mesh.kind) << i << " " << testing::PrintToString(mesh.positions[i])
                    << testing::PrintToString(other.positions[i]);
    }
  EXPECT_EQ(mesh.normals, other.normals) << to_string(mesh.kind);
  EXPECT_EQ(mesh.uv, other.uv) << to_string(mesh.kind);
  EXPECT_EQ(mesh.indices, other.indices) << to_string(mesh.kind);
  EXPECT_EQ(mesh.colors, other.colors) << to_string(mesh.kind);
  EXPECT_EQ(mesh.tile_uv, other.tile_uv) << to_string(mesh.kind);
}

TEST(BuildScene, neither_threads_nor_blocks_change_a_byte) {
  if (sanitized) GTEST_SKIP() << runs_again;
  const FullSite site;
  SceneResult first;
  const auto one = build_all(site, {.block_tiles = 4, .threads = 1}, first);
  EXPECT_EQ(first.tiles, 4U);
  EXPECT_GT(first.buildings, 40U);
  EXPECT_GT(first.trees, 300U);
  for (const SceneOptions& options :
       {SceneOptions{.block_tiles = 4, .threads = 3}, SceneOptions{.block_tiles = 1, .threads = 1},
        SceneOptions{.block_tiles = 1, .threads = 3}}) {
    SCOPED_TRACE(std::to_string(options.block_tiles) + " tiles, threads " + std::to_string(options.threads));
    SceneResult result;
    const auto others = build_all(site, options, result);
    EXPECT_EQ(result.buildings, first.buildings);
    EXPECT_EQ(result.trees, first.trees);
    EXPECT_EQ(result.road_triangles, first.road_triangles);
    EXPECT_EQ(result.findings.size(), first.findings.size());
    ASSERT_EQ(one.size(), others.size());
    for (const auto& [address, tile] : one) {
      SCOPED_TRACE(std::to_string(address.column) + " " + std::to_string(address.row));
      const SceneTile& other = others.at(address);
      ASSERT_EQ(tile.meshes.size(), other.meshes.size());
      for (std::size_t m = 0; m < tile.meshes.size(); ++m) expect_same(tile.meshes[m], other.meshes[m]);
      ASSERT_EQ(tile.instanced.size(), other.instanced.size());
      for (std::size_t m = 0; m < tile.instanced.size(); ++m) {
        expect_same(tile.instanced[m].mesh, other.instanced[m].mesh);
        ASSERT_EQ(tile.instanced[m].instances.size(), other.instanced[m].instances.size());
        for (std::size_t k = 0; k < tile.instanced[m].instances.size(); ++k)
          EXPECT_EQ(tile.instanced[m].instances[k].position, other.instanced[m].instances[k].position);
      }
      EXPECT_EQ(tile.texture_rgb.data, other.texture_rgb.data);
      EXPECT_EQ(tile.labels.data, other.labels.data);
    }
  }
}

/// A tile of any level, as bytes.
using TileBytes = std::map<std::tuple<int, int, int>, std::string>;
class TileBytesSink {
 public:
  void write(const SceneTile& tile) {
    ByteWriter writer;
    writer(tile);
    const std::lock_guard lock(mutex_);
    EXPECT_TRUE(tiles.emplace(std::tuple(tile.level, tile.column, tile.row), writer.take()).second) << "twice";
  }
  TileBytes tiles;

 private:
  std::mutex mutex_;
};

TEST(BuildScene, cells_made_by_several_processes_are_the_whole) {
  const FullSite site;
  const SceneSource source = source_of(site.input());
  for (const int block_tiles : {1, 2}) {  // four cells below one coarse tile; one cell with all levels
    SCOPED_TRACE(block_tiles);
    const SceneOptions options{.block_tiles = block_tiles, .threads = 2};
    TileBytesSink whole;
    const SceneResult expected = build_scene(
        source, [&](const SceneTile& tile) { whole.write(tile); }, options);
    ASSERT_EQ(expected.levels, 2);

    std::vector<std::string> made(block_tiles == 1 ? 4U : 1U);
    TileBytesSink shared;
    std::size_t now = 0;
    for (const std::size_t worker : {0U, 1U}) {  // the last cell of four is left
      std::size_t asked = worker;
      const auto next = [&](std::size_t count) {
        EXPECT_EQ(count, made.size());
        const std::size_t cell = std::exchange(asked, asked + 2);
        return cell < std::min(count, std::size_t{3}) ? std::optional(cell) : std::nullopt;
      };
      build_scene_cells(source, next,
                        {.begin = [&](std::size_t cell) { now = cell; },
                         .write = [&](const SceneTile& tile) { shared.write(tile); },
                         .finish = [&](const std::string& bytes) { made[now] = bytes; }},
                        options);
    }
    const auto taken = [&](std::size_t cell) { return made[cell].empty() ? std::nullopt : std::optional(made[cell]); };
    const SceneResult result = build_scene(
        source, [&](const SceneTile& tile) { shared.write(tile); }, options, nullptr, taken);
    EXPECT_EQ(shared.tiles, whole.tiles);
    EXPECT_EQ(result.tiles, expected.tiles);
    EXPECT_EQ(result.road_triangles, expected.road_triangles);
    EXPECT_EQ(result.road_surface_m2, expected.road_surface_m2);
    EXPECT_EQ(result.buildings, expected.buildings);
    EXPECT_EQ(result.findings.size(), expected.findings.size());

    made[0].resize(made[0].size() / 2);
    EXPECT_THROW((void)build_scene(
                     source, [](const SceneTile&) {}, options, nullptr, taken),
                 InputError);
  }
}

}  // namespace
}  // namespace orthodrive
