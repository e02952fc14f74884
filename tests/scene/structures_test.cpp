#include "orthodrive/scene/structures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using namespace scene_test;

constexpr double pi = std::numbers::pi;

/// A bridge of 120 m over a flat valley 9 m below, in line with roads on both banks; a road of 8 m crosses below its
/// middle.
Site valley_site() {
  const auto valley = [](Vec2 p) {
    const double x = std::abs(p.x - west_m - 240.0);
    return 10.0 + 9.0 * std::clamp((x - 50.0) / 10.0, 0.0, 1.0);
  };
  return make_site(
      480.0,
      {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 140.0, .z_m = 19.0},
       {.start = {west_m + 180.0, south_m + 240.0}, .length_m = 120.0, .z_m = 19.0, .layer = 1, .bridge = true},
       {.start = {west_m + 300.0, south_m + 240.0}, .length_m = 140.0, .z_m = 19.0},
       {.start = {west_m + 240.0, south_m + 40.0}, .heading_rad = 0.5 * pi, .length_m = 400.0, .width_m = 8.0}},
      valley);
}

const TriMesh* structure_of(const SceneTile& tile) { return find_mesh(tile, MeshKind::structure); }

SceneTile build(const Site& site) { return build_scene_tile(*lay_out_scene(site.input()), {1000, 13000}); }

TEST(Structures, faces_look_outwards) {
  const SceneTile tile = build(valley_site());
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  // A closed body's faces sum up to nothing, and its volume is positive; the bars and posts here are all but closed.
  double volume = 0.0;
  for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = mesh->positions[mesh->indices[i + k]];
      c[k] = {p[0], p[1], p[2]};
    }
    const Vec3 a = c[1], b = c[2];
    volume +=
        (c[0].x * (a.y * b.z - a.z * b.y) + c[0].y * (a.z * b.x - a.x * b.z) + c[0].z * (a.x * b.y - a.y * b.x)) / 6.0;
  }
  EXPECT_GT(volume, 100.0) << "two beams of 120 m x 0.5 m x 0.95 m, girders and piers";
}

TEST(Structures, decks_have_beams_and_railings_along_their_sides_only) {
  const SceneTile tile = build(valley_site());
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  double west = 1e9, east = -1e9, top = -1e9;
  int on_road = 0;
  for (const auto& position : mesh->positions) {
    const Vec3 p = world(tile, position);
    west = std::min(west, p.x), east = std::max(east, p.x), top = std::max(top, p.z);
    const double beside = std::abs(p.y - south_m - 240.0);
    if (p.z > 19.0 && beside < 3.0 - 1e-3) ++on_road;
    EXPECT_LE(beside, 3.5 + 1e-3);
  }
  EXPECT_NEAR(west, west_m + 180.0, 0.1);
  EXPECT_NEAR(east, west_m + 300.0, 0.1);
  EXPECT_NEAR(top, 19.0 + 0.15 + 1.0, 1e-3);
  EXPECT_EQ(on_road, 0) << "nothing stands on the deck, nor across its ends";
}

TEST(Structures, piers_stand_on_the_ground_and_on_no_road) {
  const Site site = valley_site();
  const SceneTile tile = build(site);
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  std::vector<double> feet;
  for (const auto& position : mesh->positions) {
    const Vec3 p = world(tile, position);
    if (p.z > 10.5) continue;
    EXPECT_LT(p.z, 10.0) << "in the ground";
    EXPECT_GT(std::abs(p.x - west_m - 240.0), 4.0 + 0.7) << "beside the road below";
    feet.push_back(p.x - west_m);
  }
  std::ranges::sort(feet);
  ASSERT_FALSE(feet.empty());
  int piers = 1;
  for (std::size_t i = 1; i < feet.size(); ++i) piers += static_cast<int>(feet[i] - feet[i - 1] > 5.0);
  EXPECT_EQ(piers, 4) << "five spans of 24 m";
}

TEST(Structures, low_decks_have_no_piers) {
  const Site site = make_site(
      480.0, {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 140.0, .z_m = 12.0},
              {.start = {west_m + 180.0, south_m + 240.0}, .length_m = 80.0, .z_m = 12.0, .layer = 1, .bridge = true}});
  const SceneTile tile = build(site);
  for (const auto& position : structure_of(tile)->positions) EXPECT_GE(world(tile, position).z, 12.0 - 0.8 - 1e-3);
}

TEST(Structures, motorways_have_guard_rails_but_no_other_roads_and_none_at_junctions) {
  Site site =
      make_site(480.0, {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 200.0, .width_m = 10.0},
                        {.start = {west_m + 40.0, south_m + 100.0}, .length_m = 200.0},
                        {.start = {west_m + 140.0, south_m + 240.0}, .heading_rad = 0.5 * pi, .length_m = 100.0}});
  EXPECT_EQ(structure_of(build(site)), nullptr);
  site.roads.roads[0].highway = "motorway";
  const SceneTile tile = build(site);
  const TriMesh* rails = structure_of(tile);
  ASSERT_TRUE(rails);
  double top = -1e9;
  for (const auto& position : rails->positions) {
    const Vec3 p = world(tile, position);
    const double beside = std::abs(p.y - south_m - 240.0);
    EXPECT_GT(beside, 5.7);
    EXPECT_LT(beside, 6.0);
    EXPECT_FALSE(p.y > south_m + 240.0 && std::abs(p.x - west_m - 140.0) < 3.0) << "across the side road";
    top = std::max(top, p.z);
  }
  EXPECT_NEAR(top, 10.75, 0.01);
}

TEST(Structures, guard_rails_follow_a_bend) {
  constexpr double radius_m = 120.0, width_m = 10.0;
  Site site = make_site(480.0, {{.start = {west_m + 100.0, south_m + 60.0},
                                 .length_m = 0.5 * pi * radius_m,
                                 .width_m = width_m,
                                 .curvature_1pm = 1.0 / radius_m}});
  site.roads.roads[0].highway = "motorway";
  const SceneTile tile = build(site);
  const TriMesh* rails = structure_of(tile);
  ASSERT_TRUE(rails);
  const Vec2 centre{west_m + 100.0, south_m + 60.0 + radius_m};
  std::set<int> seen_deg[2];  // inside and outside of the bend, in parts of 5 degrees
  for (const auto& position : rails->positions) {
    const Vec3 p = world(tile, position);
    const double off_m = distance({p.x, p.y}, centre) - radius_m;
    EXPECT_NEAR(std::abs(off_m), 0.5 * width_m + 0.85, 0.2);
    seen_deg[off_m > 0.0].insert(static_cast<int>(std::atan2(p.x - centre.x, centre.y - p.y) * 180.0 / pi / 5.0));
  }
  for (const auto& seen : seen_deg) EXPECT_GE(seen.size(), 17U) << "all along the quarter circle";
}

}  // namespace
}  // namespace orthodrive::scene
