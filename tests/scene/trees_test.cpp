// SPDX-License-Identifier: Apache-2.0
// Trees on small sites: nothing of them over a road, nothing in a building.

#include "orthodrive/scene/plants/trees.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "orthodrive/core/random.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "scene/placed.hpp"
#include "scene/scene_site.hpp"

namespace orthodrive {
namespace {

using namespace scene_test;
using scene::PlacedTree;

/// Vegetation everywhere: trees wherever they may be.
LabelMap all_vegetation(const Site& site) {
  LabelMap labels{Crs{"EPSG:32633"}, site.photo.frame, {}, default_class_table()};
  labels.labels = Raster<std::uint8_t>(site.photo.frame.width, site.photo.frame.height, 1, 4);
  return labels;
}

Site crossing() {
  Site site = make_site(
      480.0,
      {{.start = {west_m, south_m + 200.0}, .heading_rad = 0.3, .length_m = 500.0},
       {.start = {west_m + 240.0, south_m}, .heading_rad = 1.4, .length_m = 490.0},
       {.start = {west_m + 20.0, south_m + 440.0}, .length_m = 300.0, .z_m = 18.0, .layer = 1, .bridge = true}},
      [](Vec2 p) { return 10.0 + 0.05 * (p.x - west_m); });
  Random random(11);
  for (std::uint8_t& v : site.photo.rgb.data) v = static_cast<std::uint8_t>(random.below(256));
  return site;
}

std::vector<Building> town() {
  Random random(12);
  std::vector<Building> buildings;
  for (int i = 0; i < 60; ++i) {
    const double x = west_m + random.uniform(0.0, 450.0), y = south_m + random.uniform(0.0, 450.0);
    buildings.push_back({.footprint = {{{x, y}, {x + 14.0, y + 3.0}, {x + 12.0, y + 12.0}, {x - 2.0, y + 9.0}}, {}}});
  }
  return buildings;
}

double border_distance_m(Vec2 p, const Polygon& polygon) {
  double nearest = 1e9;
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 a = ring[i], ab = ring[(i + 1) % ring.size()] - a;
      const double u = std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0);
      nearest = std::min(nearest, distance(p, a + ab * u));
    }
  };
  add(polygon.outer);
  for (const Ring& hole : polygon.holes) add(hole);
  return nearest;
}

void expect_clear(const SceneLayout& layout) {
  std::vector<const MultiPolygon*> paved = {&layout.roads.polygons()};
  for (const scene::RoadLevel& deck : layout.decks) paved.push_back(&deck.polygons());
  MultiPolygon footprints;
  std::vector<double> roofs_m;
  for (const auto& building : layout.buildings) {
    footprints.push_back(moved(building.footprint, building.middle));
    roofs_m.push_back(building.eaves_m.empty() ? 0.0 : std::ranges::max(building.eaves_m));
  }
  EXPECT_GT(std::ranges::max(roofs_m), 0.3);
  for (const PlacedTree& tree : scene::placed<PlacedTree>(layout)) {
    const Vec2 p{tree.foot.x, tree.foot.y};
    EXPECT_TRUE(layout.area.contains(p));
    for (const MultiPolygon* set : paved) {
      for (const Polygon& polygon : *set) {
        ASSERT_FALSE(contains(polygon, p));
        ASSERT_GE(border_distance_m(p, polygon), tree.crown_radius_m + 0.29);
      }
    }
    for (std::size_t i = 0; i < footprints.size(); ++i) {
      ASSERT_FALSE(contains(footprints[i], p));
      ASSERT_GE(border_distance_m(p, footprints[i]), tree.crown_radius_m + roofs_m[i] + 0.29);
    }
  }
}

TEST(Trees, no_crown_reaches_over_a_road_or_into_a_building) {
  const Site site = crossing();
  const LabelMap labels = all_vegetation(site);
  const std::vector<Building> buildings = town();
  std::vector<Vec2> singles;
  Random random(13);
  for (int i = 0; i < 500; ++i)
    singles.push_back({west_m + random.uniform(-20.0, 500.0), south_m + random.uniform(-20.0, 500.0)});
  SceneInput input = site.input();
  input.labels = &labels, input.buildings = buildings, input.trees = singles;
  for (const double verge_m : {1.0, 5.0}) {
    const auto layout = lay_out_scene(input, {.verge_m = verge_m});
    EXPECT_GT(scene::placed<PlacedTree>(*layout).size(), 1000U);
    EXPECT_GT(layout->buildings.size(), 20U);
    expect_clear(*layout);
  }
}

TEST(Trees, of_a_map_stand_where_they_are_unless_a_crown_is_there) {
  const Site site = make_site(480.0, {});
  LabelMap labels = all_vegetation(site);
  std::ranges::fill(labels.labels.data, std::uint8_t{0});
  fill_polygon(labels.labels, labels.frame, {square(west_m + 100.0, south_m + 100.0, 10.0), {}}, std::uint8_t{4});
  SceneInput input = site.input();
  const std::vector<Vec2> singles = {{west_m + 105.0, south_m + 105.0}, {west_m + 200.0, south_m + 200.0}};
  input.labels = &labels, input.trees = singles;
  const auto layout = lay_out_scene(input);
  ASSERT_EQ(scene::placed<PlacedTree>(*layout).size(), 2U);
  EXPECT_NEAR(scene::placed<PlacedTree>(*layout)[0].foot.x, west_m + 105.0, 1.0);
  EXPECT_EQ(scene::placed<PlacedTree>(*layout)[1].foot.x, west_m + 200.0);
  EXPECT_EQ(scene::placed<PlacedTree>(*layout)[1].foot.z, 10.0);
}

TEST(Trees, small_crowns_are_shrubs_and_heights_follow_the_crown) {
  const Site site = crossing();
  const LabelMap labels = all_vegetation(site);
  SceneInput input = site.input();
  input.labels = &labels;
  const auto layout = lay_out_scene(input);
  std::array<int, scene::tree_shape_count> count{};
  for (const PlacedTree& tree : scene::placed<PlacedTree>(*layout)) {
    ++count[static_cast<std::size_t>(tree.shape)];
    EXPECT_GE(tree.crown_radius_m, 0.7);
    EXPECT_LE(tree.crown_radius_m, 5.0);
    EXPECT_LE(tree.height_m, 22.0);
    const bool shrub = tree.shape == scene::TreeShape::shrub;
    EXPECT_TRUE(shrub || tree.crown_radius_m >= 1.4);
    EXPECT_TRUE(!shrub || tree.height_m <= 2.0 * 1.7);
    EXPECT_EQ(tree.foot.z, layout->ground->height_m({tree.foot.x, tree.foot.y}));
  }
  for (const int n : count) EXPECT_GT(n, 0) << "a shape that nobody sees";
}

TEST(Trees, a_tile_has_copies_of_its_own_trees) {
  const Site site = crossing();
  const LabelMap labels = all_vegetation(site);
  SceneInput input = site.input();
  input.labels = &labels;
  const auto layout = lay_out_scene(input);
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  std::size_t copies = 0;
  for (const InstancedMesh& mesh : tile.instanced) {
    copies += mesh.instances.size();
    for (const MeshInstance& copy : mesh.instances) {
      EXPECT_LE(std::abs(copy.position[0]), 240.0F);
      EXPECT_LE(tile.origin.z + static_cast<double>(copy.position[2] + copy.scale[2]), tile.max_z_m + 1e-3);
      for (const float tint : copy.tint) EXPECT_TRUE(tint > 0.4F && tint < 2.0F);
    }
  }
  EXPECT_EQ(copies, scene::placed<PlacedTree>(*layout).size());
  EXPECT_TRUE(build_scene_tile(*layout, {1002, 13000}).instanced.empty());
}

TEST(Trees, thread_count_does_not_change_a_byte) {
  const Site site = crossing();
  const LabelMap labels = all_vegetation(site);
  SceneInput input = site.input();
  input.labels = &labels;
  const auto one = lay_out_scene(input, {.threads = 1}), four = lay_out_scene(input, {.threads = 4});
  ASSERT_EQ(scene::placed<PlacedTree>(*one).size(), scene::placed<PlacedTree>(*four).size());
  for (std::size_t i = 0; i < scene::placed<PlacedTree>(*one).size(); ++i) {
    const PlacedTree &a = scene::placed<PlacedTree>(*one)[i], &b = scene::placed<PlacedTree>(*four)[i];
    EXPECT_TRUE(a.foot.x == b.foot.x && a.foot.z == b.foot.z && a.yaw_rad == b.yaw_rad && a.color == b.color);
  }
}

}  // namespace
}  // namespace orthodrive
