// SPDX-License-Identifier: Apache-2.0
// Buildings on small sites: where they stand, how high, and that nothing overlaps.

#include "orthodrive/scene/buildings/buildings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/buildings/building_blocks.hpp"
#include "orthodrive/scene/buildings/building_mesh.hpp"
#include "orthodrive/scene/look/surface_texture.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "sanitized.hpp"
#include "scene/scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;

Building building_at(double east_m, double north_m, double width_m, double depth_m) {
  const double x = west_m + east_m, y = south_m + north_m;
  return {.footprint = {{{x, y}, {x + width_m, y}, {x + width_m, y + depth_m}, {x, y + depth_m}}, {}}};
}

std::shared_ptr<const SceneLayout> lay_out(const Site& site, const std::vector<Building>& buildings, int threads = 0) {
  SceneInput input = site.input();
  input.buildings = buildings;
  return lay_out_scene(input, {.threads = threads});
}

Polygon footprint_of(const scene::PlacedBuilding& building) { return moved(building.footprint, building.middle); }

double footprint_shared_m2(const Polygon& a, const MultiPolygon& b) {
  double sum = 0.0;
  const Vec2 from = a.outer.front() * -1.0;
  for (const Polygon& other : b)
    for (const Polygon& part : intersection_of({moved(a, from)}, union_of(std::vector{moved(other, from)}, 1e-4), 1e-4))
      sum += area_m2(part);
  return sum;
}

/// Nothing stands on a road, no two buildings share ground.
void expect_apart(const SceneLayout& layout) {
  for (std::size_t i = 0; i < layout.buildings.size(); ++i) {
    const Polygon own = footprint_of(layout.buildings[i]);
    EXPECT_EQ(footprint_shared_m2(own, layout.roads.polygons()), 0.0) << i;
    for (const scene::RoadLevel& deck : layout.decks) EXPECT_EQ(footprint_shared_m2(own, deck.polygons()), 0.0) << i;
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_LT(footprint_shared_m2(own, {footprint_of(layout.buildings[k])}), 0.011) << i << ' ' << k;
  }
}

const TriMesh* building_mesh_of(const SceneTile& tile) { return find_mesh(tile, MeshKind::building); }

/// Walls and roofs are closed but for the foot, which is in the ground; no triangle is without area. Doors are panels
/// before the walls.
void expect_shell(TriMesh mesh, const scene::PlacedBuilding& building, double origin_z_m) {
  if (!mesh.parts.empty() && mesh.parts.back().material == SurfaceMaterial::openings)
    mesh.indices.resize(mesh.parts.back().first_index);
  using Point = std::array<float, 3>;
  std::map<std::array<Point, 2>, int> edges;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
    const auto vec = [&](std::size_t k) { return Vec3{corner(k)[0], corner(k)[1], corner(k)[2]}; };
    const Vec3 a = vec(1) - vec(0), b = vec(2) - vec(0);
    EXPECT_GT(std::hypot(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x), 1e-7);
    for (std::size_t k = 0; k < 3; ++k) ++edges[{corner(k), corner((k + 1) % 3)}];
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1) << edge[0][0] << ' ' << edge[0][1] << ' ' << edge[0][2] << " to " << edge[1][0] << ' '
                        << edge[1][1] << ' ' << edge[1][2];
    if (edges.contains({edge[1], edge[0]})) continue;
    EXPECT_FALSE(building.hovers);
    EXPECT_EQ(edge[0][2], edge[1][2]);
    EXPECT_EQ(static_cast<float>(building.foot_z_m - origin_z_m), edge[0][2]);
  }
}

void expect_shells(const SceneLayout& layout) {
  const SceneTile tile = build_scene_tile(layout, {1000, 13000});
  std::vector<const scene::PlacedBuilding*> single(1);
  for (const auto& building : layout.buildings) {
    single[0] = &building;
    for (const auto detail : {scene::BuildingDetail::whole, scene::BuildingDetail::blocks})
      expect_shell(scene::building_mesh(single, tile.origin, detail), building, tile.origin.z);
  }
}

TEST(Buildings, heights_and_storeys_follow_the_tags) {
  const Site site = make_site(480.0, {});
  Building tagged = building_at(100.0, 100.0, 20.0, 10.0);
  tagged.height_m = 12.0;
  Building levels = building_at(150.0, 100.0, 20.0, 10.0);
  levels.levels = 4.0;
  levels.roof_shape = "flat";
  Building hipped = building_at(200.0, 100.0, 12.0, 10.0);
  hipped.roof_shape = "hipped";
  hipped.height_m = 9.0;
  const auto layout = lay_out(site, {tagged, levels, hipped});
  ASSERT_EQ(layout->buildings.size(), 3U);
  const auto& [a, b, c] = std::tie(layout->buildings[0], layout->buildings[1], layout->buildings[2]);
  EXPECT_EQ(a.base_z_m, 10.0);
  EXPECT_EQ(a.foot_z_m, 9.5);
  EXPECT_EQ(a.roof.shape, scene::RoofShape::gabled);
  EXPECT_DOUBLE_EQ(a.eaves_z_m + a.roof.rise_m, 22.0) << "the tag counts to the ridge";
  EXPECT_EQ(b.roof.shape, scene::RoofShape::flat);
  EXPECT_DOUBLE_EQ(b.eaves_z_m, 22.0);
  EXPECT_EQ(b.storeys, 4);
  EXPECT_EQ(c.roof.shape, scene::RoofShape::hipped);
  EXPECT_DOUBLE_EQ(c.eaves_z_m + c.roof.rise_m, 19.0);
}

TEST(Buildings, without_tags_use_and_area_decide) {
  const Site site = make_site(480.0, {});
  std::vector<Building> buildings = {building_at(50.0, 50.0, 6.0, 6.0), building_at(80.0, 50.0, 12.0, 10.0),
                                     building_at(120.0, 50.0, 40.0, 20.0), building_at(200.0, 50.0, 40.0, 30.0)};
  buildings[3].use = "industrial";
  const auto layout = lay_out(site, buildings);
  ASSERT_EQ(layout->buildings.size(), 4U);
  const std::array<double, 4> eaves_m = {2.6, 5.6, 9.0, 8.0};
  using enum scene::BuildingLook;
  const std::array<scene::BuildingLook, 4> looks = {plain, house, flats, hall};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_DOUBLE_EQ(layout->buildings[i].eaves_z_m - 10.0, eaves_m[i]);
    EXPECT_EQ(layout->buildings[i].look, looks[i]);
  }
}

TEST(Buildings, roofs_have_the_photos_colour) {
  Site site = make_site(480.0, {});
  const Building building = building_at(100.0, 100.0, 20.0, 20.0);
  fill_polygon(site.photo.valid, site.photo.frame, building.footprint, std::uint8_t{1});
  rasterize(building.footprint, site.photo.frame, [&](int row, int begin, int end) {
    for (int col = begin; col < end; ++col) site.photo.rgb.at(col, row, 0) = 255;
  });
  const auto layout = lay_out(site, {building});
  EXPECT_EQ(layout->buildings.at(0).roof_color[0], 1.0F);
  EXPECT_NEAR(layout->buildings.at(0).roof_color[1], 0.1022F, 1e-3F);  // 90 of 255, linear
}

TEST(Buildings, what_lies_on_a_road_is_cut_off_and_told) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 240.0}, .length_m = 480.0, .width_m = 8.0}});
  const auto layout = lay_out(site, {building_at(100.0, 241.0, 20.0, 13.0),   // 3 m of 13 m on the road
                                     building_at(200.0, 232.0, 20.0, 16.0),   // across: 8 m and twice 4 m beside it
                                     building_at(300.0, 244.1, 20.0, 10.0),   // beside it
                                     building_at(350.0, 237.0, 10.0, 6.0)});  // in the middle of it
  EXPECT_EQ(layout->buildings.size(), 2U);
  expect_apart(*layout);
  EXPECT_NEAR(area_m2(layout->buildings[0].footprint), 20.0 * 9.9, 0.05);
  EXPECT_NEAR(area_m2(layout->buildings[1].footprint), 200.0, 1e-6);
  ASSERT_EQ(layout->findings.size(), 3U);
  for (const Finding& finding : layout->findings) EXPECT_EQ(finding.code, "scene.building_on_road");
  EXPECT_EQ(layout->findings[0].message, "a building of 260 m2 shares 62.0 m2 with roads and is cut");
  EXPECT_EQ(layout->findings[2].message, "a building of 60 m2 shares 60.0 m2 with roads and is left out");
}

TEST(Buildings, decks_of_bridges_cut_what_would_stand_through_them) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 240.0},
                                       .length_m = 480.0,
                                       .width_m = 8.0,
                                       .z_m = 20.0,
                                       .layer = 1,
                                       .bridge = true}});
  const auto layout = lay_out(site, {building_at(100.0, 242.0, 20.0, 20.0)});
  ASSERT_EQ(layout->buildings.size(), 1U);
  expect_apart(*layout);
}

TEST(Buildings, overlapping_ones_keep_their_distance_and_neighbours_their_wall) {
  const Site site = make_site(480.0, {});
  const auto layout =
      lay_out(site, {building_at(100.0, 100.0, 20.0, 10.0), building_at(120.0, 100.0, 20.0, 10.0),   // wall to wall
                     building_at(135.0, 105.0, 30.0, 30.0), building_at(105.0, 101.0, 10.0, 8.0)});  // over, inside
  ASSERT_EQ(layout->buildings.size(), 3U);
  expect_apart(*layout);
  EXPECT_EQ(area_m2(layout->buildings[1].footprint), 200.0);
  EXPECT_NEAR(area_m2(layout->buildings[2].footprint), 900.0 - 25.0, 1e-6);
  ASSERT_EQ(layout->findings.size(), 2U);
  EXPECT_EQ(layout->findings[0].code, "scene.building_overlap");
  EXPECT_EQ(layout->findings[1].message, "a building of 80 m2 shares 80.0 m2 with others and is left out");
}

/// A town thrown at a crossing: whatever comes, the rules hold, and meshes are shells.
TEST(Buildings, hundreds_at_random_places_stand_on_no_road_and_on_no_other) {
  const Site site = make_site(480.0,
                              {{.start = {west_m, south_m + 200.0}, .heading_rad = 0.3, .length_m = 500.0},
                               {.start = {west_m + 240.0, south_m}, .heading_rad = 1.4, .length_m = 490.0},
                               {.start = {west_m + 60.0, south_m + 400.0}, .length_m = 300.0, .curvature_1pm = -0.01}},
                              [](Vec2 p) { return 10.0 + 0.05 * (p.x - west_m) + 0.02 * (p.y - south_m); });
  Random random(7);
  std::vector<Building> buildings;
  for (int i = 0; i < (sanitized ? 150 : 500); ++i) {
    const Vec2 at{west_m + random.uniform(0.0, 480.0), south_m + random.uniform(0.0, 480.0)};
    const double turn = random.uniform(0.0, 6.28), w = random.uniform(2.0, 15.0), d = random.uniform(2.0, 10.0);
    const Vec2 u{std::cos(turn), std::sin(turn)}, v = left_normal(u);
    Building building;
    building.footprint.outer = {at,
                                at + u * (2.0 * w),
                                at + u * (2.0 * w) + v * d,
                                at + u * w + v * d,
                                at + u * w + v * (2.0 * d),
                                at + v * (2.0 * d)};
    buildings.push_back(building);
  }
  const auto layout = lay_out(site, buildings);
  EXPECT_GT(layout->buildings.size(), sanitized ? 30U : 80U);
  expect_apart(*layout);
  expect_shells(*layout);
}

TEST(Buildings, bad_footprints_are_mended_or_left_out) {
  const Site site = make_site(480.0, {});
  const Vec2 at{west_m + 240.0, south_m + 240.0};
  Building bow;  // crosses itself: two triangles of 100 m2
  bow.footprint.outer = {at, at + Vec2{20.0, 20.0}, at + Vec2{20.0, 0.0}, at + Vec2{0.0, 20.0}};
  Building line;
  line.footprint.outer = {at + Vec2{50.0, 0.0}, at + Vec2{60.0, 0.0}, at + Vec2{70.0, 0.0}};
  Building nothing;
  const int corners = sanitized ? 2000 : 10000;
  Building gear;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners, r = i % 2 == 0 ? 50.0 : 48.0;
    gear.footprint.outer.push_back(at + Vec2{100.0 + r * std::cos(angle), r * std::sin(angle)});
  }
  Building circle;  // most of its corners on straight walls
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    circle.footprint.outer.push_back(at + Vec2{-100.0 + 20.0 * std::cos(angle), 20.0 * std::sin(angle)});
  }
  Building far = building_at(-500.0, 100.0, 20.0, 10.0);  // not in the area
  const auto layout = lay_out(site, {bow, line, nothing, gear, circle, far});
  ASSERT_EQ(layout->buildings.size(), 3U);
  expect_apart(*layout);
  EXPECT_NEAR(area_m2(layout->buildings[0].footprint), 100.0, 0.1);
  EXPECT_EQ(layout->buildings[1].roof.shape, scene::RoofShape::flat);
  EXPECT_LT(layout->buildings[2].footprint.outer.size(), 200U);
  EXPECT_NEAR(area_m2(layout->buildings[2].footprint), 400.0 * std::numbers::pi, 3.0);
  expect_shells(*layout);
}

std::set<SurfaceMaterial> materials_of(const TriMesh& mesh) {
  std::set<SurfaceMaterial> materials;
  for (const MeshPart& part : mesh.parts) materials.insert(part.material);
  return materials;
}

TEST(Buildings, mesh_has_walls_with_storeys_of_windows_and_a_roof) {
  const Site site = make_site(480.0, {});
  Building block = building_at(100.0, 100.0, 32.0, 16.0);
  block.use = "school";
  block.levels = 3.0;
  block.roof_shape = "gabled";
  const SceneTile tile = build_scene_tile(*lay_out(site, {block}), {1000, 13000});
  const TriMesh* mesh = building_mesh_of(tile);
  ASSERT_NE(mesh, nullptr);
  EXPECT_EQ(materials_of(*mesh), (std::set{SurfaceMaterial::concrete, SurfaceMaterial::facade,
                                           SurfaceMaterial::roof_tiles, SurfaceMaterial::openings}));
  ASSERT_EQ(mesh->parts[1].material, SurfaceMaterial::facade);
  // The long wall: ten bays of four in the picture, three storeys from the ground to the eaves.
  float left = 1e9F, right = -1e9F, top = 1e9F, foot = -1e9F;
  for (std::size_t k = 0; k < 6; ++k) {
    const auto& uv = mesh->tile_uv[mesh->indices[mesh->parts[1].first_index + k]];
    left = std::min(left, uv[0]), right = std::max(right, uv[0]);
    top = std::min(top, uv[1]), foot = std::max(foot, uv[1]);
  }
  EXPECT_NEAR(right - left, 10.0F / 4.0F, 1e-4F);
  EXPECT_NEAR(foot - top, (3.0F + 0.5F / 3.0F) / 4.0F, 1e-4F) << "half a metre below the ground";
  EXPECT_GT(tile.max_z_m, 19.0);
}

TEST(Buildings, look_like_what_they_are_used_for) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 90.0}, .length_m = 480.0}});
  const auto materials_by = [&](const char* use, double width_m, double depth_m, double height_m) {
    Building building = building_at(100.0, 100.0, width_m, depth_m);
    building.use = use, building.height_m = height_m;
    return materials_of(*building_mesh_of(build_scene_tile(*lay_out(site, {building}), {1000, 13000})));
  };
  using enum SurfaceMaterial;
  EXPECT_EQ(materials_by("house", 12.0, 10.0, 8.0), (std::set{concrete, facade, roof_tiles, openings}));
  EXPECT_EQ(materials_by("industrial", 40.0, 30.0, 8.0), (std::set{cladding, gravel, openings}));
  EXPECT_EQ(materials_by("apartments", 40.0, 12.0, 15.0), (std::set{balconies, gravel, concrete, openings}));
  EXPECT_EQ(materials_by("garages", 30.0, 6.0, 2.6), (std::set{concrete, gravel, openings}));
  EXPECT_EQ(materials_by("shed", 4.0, 5.0, 2.6), (std::set{concrete, gravel}));
}

TEST(Buildings, doors_and_gates_look_at_the_road) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 90.0}, .length_m = 480.0}});
  const auto layout = lay_out(site, {building_at(100.0, 100.0, 12.0, 10.0)});
  const scene::PlacedBuilding& house = layout->buildings.at(0);
  const Ring& ring = house.footprint.outer;
  EXPECT_LT((ring[house.front] + ring[(house.front + 1) % 4]).y, 0.0) << "the southern wall";
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  const TriMesh& mesh = *building_mesh_of(tile);
  const MeshPart& doors = mesh.parts.back();
  ASSERT_EQ(doors.material, SurfaceMaterial::openings);
  ASSERT_EQ(doors.index_count, 6U);
  for (std::size_t k = 0; k < 6; ++k) {
    const std::uint32_t v = mesh.indices[doors.first_index + k];
    EXPECT_NEAR(world(tile, mesh.positions[v]).y, south_m + 99.97, 1e-3);
    EXPECT_EQ(mesh.normals[v], (std::array{0.0F, -1.0F, 0.0F}));
  }
}

TEST(Buildings, eaves_stand_out_but_not_over_roads_and_neighbours) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 90.0}, .length_m = 480.0, .width_m = 8.0}});
  const auto layout = lay_out(site, {building_at(100.0, 94.5, 12.0, 10.0), building_at(112.0, 94.5, 12.0, 10.0),
                                     building_at(200.0, 200.0, 12.0, 10.0)});
  ASSERT_EQ(layout->buildings.size(), 3U);
  const auto out_m = [&](std::size_t number, Vec2 to) {
    const scene::PlacedBuilding& b = layout->buildings[number];
    for (std::size_t i = 0; i < 4; ++i)
      if (const Vec2 along = normalized(b.footprint.outer[(i + 1) % 4] - b.footprint.outer[i]);
          dot(left_normal(along) * -1.0, to) > 0.9)
        return b.eaves_m.at(i);
    return -1.0;
  };
  EXPECT_EQ(out_m(0, {0.0, -1.0}), 0.0) << "the road is half a metre away";
  EXPECT_EQ(out_m(0, {0.0, 1.0}), 0.4);
  EXPECT_EQ(out_m(0, {1.0, 0.0}), 0.0) << "the neighbour's wall";
  EXPECT_EQ(out_m(0, {-1.0, 0.0}), 0.4);
  EXPECT_EQ(layout->buildings[2].eaves_m, std::vector(4, 0.4));
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  double west = 1e9, south = 1e9;
  for (const auto& p : building_mesh_of(tile)->positions)
    west = std::min(west, world(tile, p).x - west_m), south = std::min(south, world(tile, p).y - south_m);
  EXPECT_NEAR(west, 99.6, 1e-3);
  EXPECT_NEAR(south, 94.47, 1e-3) << "a door";
  expect_shells(*layout);
}

// ---- parts

Building part_at(double east_m, double north_m, double width_m, double depth_m, double low_m, double high_m) {
  Building part = building_at(east_m, north_m, width_m, depth_m);
  part.is_part = true, part.min_height_m = low_m, part.height_m = high_m;
  part.roof_shape = "flat";
  return part;
}

TEST(BuildingParts, stand_for_their_outline) {
  const Site site = make_site(480.0, {});
  Building outline = building_at(100.0, 100.0, 40.0, 20.0);
  outline.height_m = 30.0, outline.wall_color = {{0.1F, 0.2F, 0.3F}};
  const auto layout =
      lay_out(site, {outline, part_at(100.0, 100.0, 30.0, 20.0, 0.0, 10.0),
                     part_at(130.0, 100.0, 10.0, 20.0, 0.0, 30.0), part_at(105.0, 105.0, 10.0, 10.0, 10.0, 14.0)});
  ASSERT_EQ(layout->buildings.size(), 3U) << "the outline is not drawn";
  EXPECT_TRUE(layout->findings.empty());
  const std::array<double, 3> low = {9.5, 9.5, 20.0}, high = {20.0, 40.0, 24.0};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(layout->buildings[i].foot_z_m, low[i]);
    EXPECT_DOUBLE_EQ(layout->buildings[i].eaves_z_m, high[i]);
    EXPECT_EQ(layout->buildings[i].wall_color, (LinearColor{0.1F, 0.2F, 0.3F})) << "the outline's";
    EXPECT_NEAR(area_m2(layout->buildings[i].footprint), (std::array{600.0, 200.0, 100.0}[i]), 1e-9)
        << "one over the other";
  }
  expect_shells(*layout);
}

TEST(BuildingParts, that_overlap_at_equal_height_share_nothing_and_towers_go_through) {
  const Site site = make_site(480.0, {});
  const Building outline = building_at(100.0, 100.0, 40.0, 20.0);
  const auto layout =
      lay_out(site, {outline, part_at(100.0, 100.0, 25.0, 20.0, 0.0, 10.0),
                     part_at(115.0, 100.0, 25.0, 20.0, 0.0, 10.0), part_at(108.0, 108.0, 4.0, 4.0, 0.0, 25.0)});
  ASSERT_EQ(layout->buildings.size(), 3U);
  double sum_m2 = 0.0;
  for (const auto& building : layout->buildings) sum_m2 += area_m2(building.footprint);
  EXPECT_NEAR(sum_m2, 800.0, 1e-6);
  expect_apart(*layout);
  EXPECT_EQ(layout->buildings[0].footprint.holes.size(), 1U) << "the tower stands in it";
  expect_shells(*layout);
}

TEST(BuildingParts, outside_of_all_buildings_stand_alone_and_are_told) {
  const Site site = make_site(480.0, {});
  const auto layout =
      lay_out(site, {building_at(100.0, 100.0, 20.0, 20.0), part_at(200.0, 100.0, 20.0, 20.0, 0.0, 9.0)});
  ASSERT_EQ(layout->buildings.size(), 2U);
  ASSERT_EQ(layout->findings.size(), 1U);
  EXPECT_EQ(layout->findings[0].code, "scene.part_without_building");
}

TEST(BuildingParts, of_which_little_is_there_leave_the_rest_of_the_outline) {
  const Site site = make_site(480.0, {});
  Building church = building_at(100.0, 100.0, 30.0, 12.0);
  church.use = "church";
  Building tower = part_at(96.0, 103.0, 6.0, 6.0, 0.0, 30.0);  // 2 m of it inside
  tower.footprint = building_at(100.0, 103.0, 6.0, 6.0).footprint;
  tower.roof_shape = "pyramidal", tower.roof_height_m = 8.0;
  const auto layout = lay_out(site, {church, tower});
  ASSERT_EQ(layout->buildings.size(), 2U);
  EXPECT_NEAR(area_m2(layout->buildings[0].footprint), 360.0 - 36.0, 1e-6);
  EXPECT_DOUBLE_EQ(layout->buildings[1].eaves_z_m, 10.0 + 22.0);
  EXPECT_DOUBLE_EQ(layout->buildings[1].roof.rise_m, 8.0);
  expect_apart(*layout);
  expect_shells(*layout);
}

TEST(BuildingParts, high_over_a_road_may_stand_there_but_not_low_ones) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 240.0}, .length_m = 480.0, .width_m = 8.0}});
  const Building outline = building_at(100.0, 220.0, 12.0, 40.0);
  const auto layout =
      lay_out(site, {outline, part_at(100.0, 220.0, 12.0, 16.0, 0.0, 12.0), part_at(100.0, 236.0, 12.0, 8.0, 5.0, 12.0),
                     part_at(100.0, 244.0, 12.0, 16.0, 0.0, 12.0), part_at(200.0, 236.0, 12.0, 8.0, 3.0, 12.0)});
  ASSERT_EQ(layout->buildings.size(), 3U);
  EXPECT_TRUE(layout->buildings[1].hovers);
  EXPECT_NEAR(area_m2(layout->buildings[1].footprint), 96.0, 1e-6);
  EXPECT_LT(area_m2(layout->buildings[0].footprint), 192.0 - 1.0) << "0.1 m beside the road";
  expect_shells(*layout);
}

TEST(Buildings, roofs_without_walls_stand_on_posts_beside_the_road) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 240.0}, .length_m = 480.0, .width_m = 8.0}});
  Building canopy = building_at(100.0, 230.0, 20.0, 20.0);  // a filling station over a street
  canopy.use = "roof", canopy.has_walls = false, canopy.height_m = 5.2;
  Building carport = building_at(200.0, 100.0, 6.0, 5.0);
  carport.use = "carport", carport.has_walls = false;
  const auto layout = lay_out(site, {canopy, carport});
  ASSERT_EQ(layout->buildings.size(), 2U);
  EXPECT_NEAR(area_m2(layout->buildings[0].footprint), 400.0, 1e-6);
  EXPECT_NEAR(layout->buildings[0].foot_z_m, 14.95, 1e-9);
  EXPECT_GE(layout->buildings[0].posts.size(), 4U);
  for (const Vec2 post : layout->buildings[0].posts)
    EXPECT_GT(std::abs(layout->buildings[0].middle.y + post.y - (south_m + 240.0)), 4.2);
  EXPECT_EQ(layout->buildings[1].posts.size(), 4U);
  EXPECT_NEAR(layout->buildings[1].foot_z_m, 12.35, 1e-9);
}

TEST(Buildings, keep_off_the_surface_that_goes_on_beyond_a_roads_end) {
  const Site site = make_site(480.0, {{.start = {west_m + 100.0, south_m + 240.0}, .length_m = 200.0, .width_m = 8.0}});
  const auto layout = lay_out(site, {building_at(300.1, 230.0, 20.0, 20.0)});
  ASSERT_EQ(layout->buildings.size(), 1U);
  for (const Vec2 p : footprint_of(layout->buildings[0]).outer) {
    roadquery::Cursor cursor;
    EXPECT_FALSE(layout->query->find_height(p.x, p.y, 10.0, cursor)) << p.x - west_m << ' ' << p.y - south_m;
  }
  EXPECT_LT(area_m2(layout->buildings[0].footprint), 400.0);
}

TEST(Buildings, thread_count_does_not_change_a_byte) {
  const Site site = make_site(480.0, {{.start = {west_m, south_m + 240.0}, .length_m = 480.0}});
  std::vector<Building> buildings;
  buildings.reserve(60);
  for (int i = 0; i < 60; ++i) buildings.push_back(building_at(7.0 * i, 225.0 + i % 5, 10.0 + i % 7, 12.0));
  const auto one = lay_out(site, buildings, 1), four = lay_out(site, buildings, 4);
  const SceneTile a = build_scene_tile(*one, {1000, 13000}), b = build_scene_tile(*four, {1000, 13000});
  EXPECT_EQ(building_mesh_of(a)->positions, building_mesh_of(b)->positions);
  EXPECT_EQ(building_mesh_of(a)->indices, building_mesh_of(b)->indices);
  EXPECT_EQ(building_mesh_of(a)->colors, building_mesh_of(b)->colors);
  EXPECT_EQ(one->findings.size(), four->findings.size());
}

/// A house with a gabled roof, a hall with a step of 0.3 m in its wall, a garage.
std::vector<Building> three_sizes() {
  Building hall = building_at(200.0, 100.0, 30.0, 20.0);
  hall.use = "industrial";
  const Vec2 low = hall.footprint.outer[0];
  hall.footprint.outer = {low,
                          {low.x + 15.0, low.y},
                          {low.x + 15.0, low.y + 0.3},
                          {low.x + 30.0, low.y + 0.3},
                          {low.x + 30.0, low.y + 20.0},
                          {low.x, low.y + 20.0}};
  Building garage = building_at(300.0, 100.0, 4.0, 5.0);
  garage.use = "garage";
  return {building_at(100.0, 100.0, 12.0, 10.0), hall, garage};
}

TEST(Buildings, from_afar_are_blocks_within_the_error_they_state) {
  const Site site = make_site(480.0, {});
  const auto layout = lay_out(site, three_sizes());
  ASSERT_EQ(layout->buildings.size(), 3U);
  std::vector<const scene::PlacedBuilding*> all;
  all.reserve(layout->buildings.size());
  for (const auto& building : layout->buildings) all.push_back(&building);
  const Vec3 origin = layout->origin;
  const std::size_t whole = scene::building_mesh(all, origin, scene::BuildingDetail::blocks).indices.size();
  const auto same = scene::building_blocks(all, origin, {.outline_m = 0.1, .roof_m = 0.1});
  EXPECT_EQ(same.mesh.indices.size(), whole) << "nothing is that small";
  double details_m = 0.0;
  for (const auto* building : all) details_m = std::max(details_m, scene::detail_reach_m(*building));
  EXPECT_EQ(same.error_m, details_m) << "eaves, parapets and chimneys";
  EXPECT_GE(details_m, 0.4);
  const auto straight = scene::building_blocks(all, origin, {.outline_m = 0.5, .roof_m = 1.0});
  EXPECT_EQ(straight.mesh.indices.size(), whole - 2 * 9) << "two walls of two triangles, and two of the roof";
  EXPECT_EQ(straight.error_m, std::max(0.5, details_m));
  const auto blocks = scene::building_blocks(all, origin, {.outline_m = 1.0, .roof_m = 2.0, .size_m = 4.0});
  EXPECT_EQ(blocks.mesh.indices.size(), 2U * 3U * (8U + 2U)) << "two boxes without floors";
  EXPECT_NEAR(blocks.error_m, 2.6, 1e-9) << "the garage";
  double highest_m = 0.0;
  for (const auto& p : blocks.mesh.positions) {
    if (p[0] < all[0]->middle.x + 10.0 - origin.x) highest_m = std::max(highest_m, double{p[2]});
  }
  EXPECT_NEAR(highest_m + origin.z, all[0]->eaves_z_m + 0.5 * all[0]->roof.rise_m, 1e-4);
}

TEST(Buildings, have_the_colours_of_the_map) {
  const Site site = make_site(480.0, {});
  const std::vector<Building> buildings = {
      {.footprint = {square(west_m + 100.0, south_m + 100.0, 12.0), {}}, .wall_color = {{0.1F, 0.2F, 0.3F}}},
      {.footprint = {square(west_m + 200.0, south_m + 100.0, 12.0), {}}, .roof_color = {{0.3F, 0.2F, 0.1F}}}};
  SceneInput input = site.input();
  input.buildings = buildings;
  const auto layout = lay_out_scene(input);
  ASSERT_EQ(layout->buildings.size(), 2U);
  EXPECT_EQ(layout->buildings[0].wall_color, (LinearColor{0.1F, 0.2F, 0.3F}));
  EXPECT_NEAR(layout->buildings[0].roof_color[0], 0.1022F, 1e-3F) << "the photo's";
  EXPECT_EQ(layout->buildings[1].roof_color, (LinearColor{0.3F, 0.2F, 0.1F}));
}

}  // namespace
}  // namespace orthodrive
