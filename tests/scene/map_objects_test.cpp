// SPDX-License-Identifier: Apache-2.0
// Signs, traffic lights, furniture, towers and wires: where they stand and look, and that none stands on a road.

#include "orthodrive/scene/objects/map_objects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/tiles/coarse_tile.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "sanitized.hpp"
#include "scene/placed.hpp"
#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using namespace scene_test;

constexpr int last_kind = static_cast<int>(ObjectKind::storage_tank);

Vec2 object_at(double east_m, double north_m) { return {west_m + east_m, south_m + north_m}; }

std::shared_ptr<const SceneLayout> lay_out_objects(const Site& site, const MapSurroundings& surroundings,
                                                   const std::vector<Building>& buildings = {}) {
  SceneInput input = site.input();
  input.surroundings = &surroundings;
  input.buildings = buildings;
  return lay_out_scene(input);
}

std::vector<StructureFace> faces_of(const std::map<TileAddress, std::vector<StructureFace>>& tiles) {
  std::vector<StructureFace> all;
  for (const auto& [address, faces] : tiles) all.insert(all.end(), faces.begin(), faces.end());
  return all;
}

struct Bounds {
  Vec3 low{1e18, 1e18, 1e18}, high{-1e18, -1e18, -1e18};
};
Bounds bounds(const std::vector<StructureFace>& faces) {
  Bounds b;
  for (const StructureFace& face : faces)
    for (const Vec3& c : face.corners) {
      b.low = {std::min(b.low.x, c.x), std::min(b.low.y, c.y), std::min(b.low.z, c.z)};
      b.high = {std::max(b.high.x, c.x), std::max(b.high.y, c.y), std::max(b.high.z, c.z)};
    }
  return b;
}

TEST(MapObjects, every_kind_stands_on_the_ground) {
  const Site site = make_site(480.0, {}, [](Vec2 p) { return 10.0 + 0.1 * (p.x - west_m); });
  for (int kind = 0; kind <= last_kind; ++kind) {
    const auto layout = lay_out_objects(site, {.objects = {{static_cast<ObjectKind>(kind), object_at(200, 200)}}});
    std::vector<StructureFace> faces = faces_of(scene::placed_faces(*layout, MeshKind::object));
    std::ranges::move(faces_of(scene::placed_faces(*layout, MeshKind::barrier)), std::back_inserter(faces));
    ASSERT_FALSE(faces.empty()) << kind;
    const Bounds b = bounds(faces);
    EXPECT_LT(b.low.z, 30.0) << kind << " has its foot in the ground";
    EXPECT_GT(b.low.z, 29.0) << kind;
    EXPECT_GT(b.high.z, 30.6) << kind;
    EXPECT_NEAR(0.5 * (b.low.y + b.high.y), south_m + 200.0, 0.4) << kind;
  }
}

TEST(MapObjects, none_stands_on_a_road_in_a_building_or_before_a_portal) {
  const Site site =
      make_site(480.0, {{.start = object_at(40, 240), .length_m = 400.0},
                        {.start = object_at(240, 40), .heading_rad = 1.2, .length_m = 380.0, .width_m = 9.0},
                        {.start = object_at(60, 60), .length_m = 300.0, .curvature_1pm = 0.004},
                        {.start = object_at(40, 400), .length_m = 300.0, .z_m = 9.0, .tunnel = true}});
  std::vector<Building> buildings;
  for (int k = 0; k < 12; ++k) {
    const Vec2 p = object_at(60.0 + 33.0 * k, 300.0 - 9.0 * k);
    buildings.push_back({.footprint = {{p, p + Vec2{14.0, 3.0}, p + Vec2{11.0, 12.0}, p + Vec2{-3.0, 9.0}}, {}}});
  }
  MapSurroundings surroundings;
  Random random(11);
  const int count = sanitized ? 500 : 3000;
  for (int k = 0; k < count; ++k)
    surroundings.objects.push_back({static_cast<ObjectKind>(k % (last_kind + 1)),
                                    object_at(random.uniform(0.0, 480.0), random.uniform(0.0, 480.0))});
  const auto layout = lay_out_objects(site, surroundings, buildings);
  MultiPolygon taken = layout->roads.polygons();
  for (const RoadLevel& tunnel : layout->tunnels)
    taken.insert(taken.end(), tunnel.polygons().begin(), tunnel.polygons().end());
  for (const PlacedBuilding& building : layout->buildings) taken.push_back(moved(building.footprint, building.middle));
  ASSERT_GE(layout->buildings.size(), 8U);
  // Only the arms of power towers reach further, 20 m up.
  auto low = scene::placed_faces(*layout, MeshKind::barrier);
  for (auto& [address, faces] : low)
    std::erase_if(faces, [](const StructureFace& face) { return face.corners[0].z > 29.0; });
  EXPECT_GT(faces_of(scene::placed_faces(*layout, MeshKind::object)).size(), count * 10U / 3U);
  EXPECT_GT(faces_of(low).size(), count * 5U / 3U);
  EXPECT_EQ(shared_m2(scene::placed_faces(*layout, MeshKind::object), taken), 0.0);
  EXPECT_EQ(shared_m2(low, taken), 0.0);
}

TEST(MapObjects, signs_on_the_road_come_beside_it_and_look_at_who_comes) {
  const Site site = make_site(480.0, {{.start = object_at(40, 240), .length_m = 400.0}});
  for (const bool near_end : {false, true}) {
    const double east = near_end ? 430.0 : 60.0;
    const auto layout = lay_out_objects(site, {.objects = {{ObjectKind::stop_sign, object_at(east, 240)}}});
    const auto faces = faces_of(scene::placed_faces(*layout, MeshKind::object));
    const Bounds b = bounds(faces);
    // Eastbound traffic has the sign in the south, and sees a face towards the west.
    EXPECT_NEAR(0.5 * (b.low.y + b.high.y) - south_m - 240.0, near_end ? -3.7 : 3.7, 0.05);
    EXPECT_NEAR(b.high.z, 12.85, 0.05);
    double looks = 0.0;
    for (const StructureFace& face : faces) {
      if (!(face.color[0] > 0.4F && face.color[1] < 0.1F)) continue;  // the red plate
      const Vec3 u = face.corners[2] - face.corners[0], v = face.corners[3] - face.corners[1];
      looks += u.y * v.z - u.z * v.y;
    }
    EXPECT_EQ(looks < 0.0, near_end);
  }
}

TEST(MapObjects, traffic_lights_of_a_junction_stand_at_its_arms_once) {
  Site site = make_site(480.0, {{.start = object_at(40, 240), .length_m = 190.0},
                                {.start = object_at(230, 240), .length_m = 20.0},
                                {.start = object_at(250, 240), .length_m = 190.0}});
  auto& roads = site.roads.roads;
  roads[1].junction = 5;
  roads[0].successor = {roadquery::LinkKind::junction, 5};
  roads[2].predecessor = {roadquery::LinkKind::junction, 5};
  const auto layout = lay_out_objects(site, {.objects = {{ObjectKind::traffic_signals, object_at(240, 240)},
                                                         {ObjectKind::traffic_signals, object_at(243, 240)}}});
  const auto faces = faces_of(scene::placed_faces(*layout, MeshKind::object));
  const auto with_one = lay_out_objects(site, {.objects = {{ObjectKind::traffic_signals, object_at(240, 300)}}});
  const auto one = faces_of(scene::placed_faces(*with_one, MeshKind::object));
  EXPECT_EQ(faces.size(), 2 * one.size());
  const Bounds b = bounds(faces);
  EXPECT_NEAR(b.low.x, west_m + 229.0, 0.4);
  EXPECT_NEAR(b.high.x, west_m + 251.0, 0.4);
}

TEST(MapObjects, wires_hang_in_catenaries_between_their_poles) {
  const double span_m = 200.0;
  const Site site = make_site(480.0, {}, [](Vec2 p) { return 10.0 + 0.05 * (p.x - west_m); });
  const auto layout = lay_out_objects(site, {.power_lines = {{{object_at(100, 200), object_at(100 + span_m, 200)}}}});
  const double c = span_m * span_m / (8.0 * 0.025 * span_m);
  int places = 0;
  for (const StructureFace& face : faces_of(scene::placed_faces(*layout, MeshKind::object)))
    for (const Vec3& p : face.corners) {
      const double x = p.x - west_m - 100.0 - 0.5 * span_m;
      const double z =
          30.0 + 10.0 * (x / span_m + 0.5) - (10.0 - 5.0) + 0.0 * x;  // ends: ground 15 m and 25 m, 20 m over it
      const double sag = c * (std::cosh(0.5 * span_m / c) - std::cosh(x / c));
      EXPECT_NEAR(p.z, z + 10.0 - sag, 0.05);
      ++places;
    }
  EXPECT_GE(places, 3 * 3 * 4 * 10);
  const Bounds b = bounds(faces_of(scene::placed_faces(*layout, MeshKind::object)));
  EXPECT_NEAR(b.high.y - b.low.y, 10.0, 0.1);
}

TEST(MapObjects, odd_ones_give_nothing_and_coarse_tiles_keep_the_large_ones) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Site site = make_site(480.0, {});
  const auto none = lay_out_objects(
      site, {.objects = {{ObjectKind::bench, {nan, 0.0}}, {ObjectKind::bench, object_at(-50, 0)}},
             .power_lines = {{{object_at(0, 0), object_at(1e7, 0)}}, {{}}, {{object_at(5, 5), object_at(5, 5)}}}});
  EXPECT_TRUE(scene::placed_faces(*none, MeshKind::object).empty());
  const auto layout = lay_out_objects(
      site, {.objects = {{ObjectKind::bench, object_at(100, 100)}, {ObjectKind::chimney, object_at(200, 200), 60.0}}});
  SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  EXPECT_TRUE(find_mesh(tile, MeshKind::object));
  EXPECT_NEAR(tile.max_z_m, 70.0, 0.01);
  tile = ready_to_coarsen(std::move(tile));
  EXPECT_FALSE(find_mesh(tile, MeshKind::object));
  EXPECT_TRUE(find_mesh(tile, MeshKind::barrier)) << "the chimney";
}

}  // namespace
}  // namespace orthodrive::scene
