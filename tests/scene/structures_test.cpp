// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/structures/structures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "orthodrive/scene/roads/crossing_roads.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using namespace scene_test;

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
const TriMesh* rails_of(const SceneTile& tile) { return find_mesh(tile, MeshKind::rails); }

SceneTile build_tile(const Site& site) { return build_scene_tile(*lay_out_scene(site.input()), {1000, 13000}); }

TEST(Structures, faces_look_outwards) {
  const SceneTile tile = build_tile(valley_site());
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
  const SceneTile tile = build_tile(valley_site());
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  double west = 1e9, east = -1e9, top = -1e9;
  int on_road = 0;
  ASSERT_TRUE(rails_of(tile));
  std::vector<std::array<float, 3>> positions = mesh->positions;
  positions.insert(positions.end(), rails_of(tile)->positions.begin(), rails_of(tile)->positions.end());
  for (const auto& position : positions) {
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
  const SceneTile tile = build_tile(site);
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

TEST(Structures, no_face_of_a_beam_lies_in_the_side_of_the_deck) {
  const SceneTile tile = build_tile(valley_site());
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  int in_side = 0;
  for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
    bool is_in_side = true;
    double low = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = world(tile, mesh->positions[mesh->indices[i + k]]);
      is_in_side = is_in_side && std::abs(std::abs(p.y - south_m - 240.0) - 3.0) < 1e-3;
      low = std::min(low, p.z);
    }
    in_side += static_cast<int>(is_in_side && low < 19.0 - 1e-3);
  }
  EXPECT_EQ(in_side, 0) << "they would flicker";
}

TEST(Structures, abutments_close_the_ends_of_decks_down_into_the_ground) {
  const Site site = valley_site();
  const auto layout = lay_out_scene(site.input());
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  std::map<bool, std::array<double, 2>> across;  // by bank: lowest and highest of the wall across
  for (std::size_t i = 0; i < mesh->indices.size(); i += 3) {
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = world(tile, mesh->positions[mesh->indices[i + k]]);
    const double wide = std::max({c[0].y, c[1].y, c[2].y}) - std::min({c[0].y, c[1].y, c[2].y});
    if (c[0].x != c[1].x || c[1].x != c[2].x || wide < 5.5) continue;
    const bool east = c[0].x > west_m + 240.0;
    if (std::abs(c[0].x - west_m - 240.0) < 47.0) continue;  // a pier
    EXPECT_EQ(mesh->normals[mesh->indices[i]][0], east ? -1.0F : 1.0F) << "towards the valley";
    auto& [low, high] = across.try_emplace(east, std::array{1e9, -1e9}).first->second;
    for (const Vec3& p : c) {
      low = std::min(low, p.z), high = std::max(high, p.z);
      EXPECT_GT(layout->ground->height_m({p.x, p.y}), low);
    }
  }
  ASSERT_EQ(across.size(), 2U) << "one on each bank";
  for (const auto& [east, extent] : across) EXPECT_NEAR(extent[1], 19.0 - 0.8 + 0.05, 2e-3) << "to the deck";
}

/// Two bridges of one layer, one 7 m over the other, and one that runs on from the first.
std::vector<RoadShape> crossing_bridges() {
  return {{.start = {west_m + 140.0, south_m + 240.0}, .length_m = 100.0, .z_m = 16.0, .layer = 1, .bridge = true},
          {.start = {west_m + 200.0, south_m + 180.0},
           .heading_rad = 0.5 * pi,
           .length_m = 120.0,
           .z_m = 23.0,
           .layer = 1,
           .bridge = true},
          {.start = {west_m + 240.0, south_m + 240.0}, .length_m = 50.0, .z_m = 16.0, .layer = 1, .bridge = true}};
}

TEST(Structures, roads_of_one_layer_that_cross_are_told_apart) {
  Site site = make_site(480.0, crossing_bridges());
  auto& roads = site.roads.roads;
  roads[0].successor = {roadquery::LinkKind::road, roads[2].id};
  const std::vector<const roadquery::Road*> all = {&roads[0], &roads[1], &roads[2]};
  const auto sets = told_apart(all);
  ASSERT_EQ(sets.size(), 2U);
  EXPECT_EQ(sets[0], (std::vector<const roadquery::Road*>{&roads[0], &roads[2]})) << "they run on into each other";
  EXPECT_EQ(sets[1], std::vector<const roadquery::Road*>{&roads[1]});

  const SceneTile tile = build_tile(site);
  const TriMesh* road = find_mesh(tile, MeshKind::road);
  ASSERT_TRUE(road);
  EXPECT_NEAR(scene_test::plan_area_m2(road), (100.0 + 120.0 + 50.0) * 6.0, 1.0) << "both, where they cross";
  for (const auto& position : road->positions) {
    const Vec3 p = world(tile, position);
    const bool upper = std::abs(p.z - 23.0) < 0.01;
    EXPECT_TRUE(upper || std::abs(p.z - 16.0) < 0.01) << p.z << ": neither between nor on both";
    if (upper) {
      EXPECT_LE(std::abs(p.x - west_m - 200.0), 3.0 + 1e-3);
    }
  }
  // The same height: one surface.
  roads[1].elevation = {{.a = 16.5}};
  EXPECT_EQ(told_apart(all).size(), 1U);
}

TEST(Structures, no_edge_at_the_joints_of_a_deck_has_more_than_two_triangles) {
  Site site = valley_site();
  std::vector<roadquery::Road>& roads = site.roads.roads;
  for (std::size_t i = 0; i < 2; ++i) {
    roads[i].successor = {roadquery::LinkKind::road, roads[i + 1].id, roadquery::ContactPoint::start};
    roads[i + 1].predecessor = {roadquery::LinkKind::road, roads[i].id, roadquery::ContactPoint::end};
  }
  const SceneTile tile = build_tile(site);
  using Place = std::array<float, 3>;
  std::map<std::pair<Place, Place>, int> triangles;
  int across_joints = 0;
  for (const MeshKind kind : {MeshKind::terrain, MeshKind::road, MeshKind::road_body}) {
    const TriMesh* mesh = find_mesh(tile, kind);
    ASSERT_TRUE(mesh);
    for (std::size_t i = 0; i < mesh->indices.size(); ++i) {
      const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
      const auto edge = std::minmax({mesh->positions[mesh->indices[i]], mesh->positions[mesh->indices[next]]});
      ++triangles[edge];
    }
  }
  for (const auto& [edge, count] : triangles) {
    EXPECT_LE(count, 2) << edge.first[0] << " " << edge.first[1] << " " << edge.first[2];
    const bool is_across = edge.first[0] == edge.second[0] && std::abs(std::abs(edge.first[0]) - 60.0F) < 0.01F;
    across_joints += static_cast<int>(is_across && count == 2);
  }
  EXPECT_GT(across_joints, 8) << "road and deck, ground and end wall, at both ends";
}

TEST(Structures, low_decks_have_no_piers) {
  const Site site = make_site(
      480.0, {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 140.0, .z_m = 12.0},
              {.start = {west_m + 180.0, south_m + 240.0}, .length_m = 80.0, .z_m = 12.0, .layer = 1, .bridge = true}});
  const SceneTile tile = build_tile(site);
  for (const auto& position : structure_of(tile)->positions) {
    const Vec3 p = world(tile, position);
    if (std::abs(p.x - west_m - 220.0) < 40.0 - 5.0) {  // the abutments are nearer to the ends
      EXPECT_GE(p.z, 12.0 - 0.8 - 1e-3);
    }
  }
}

TEST(Structures, motorways_have_guard_rails_but_no_other_roads_and_none_at_junctions) {
  Site site =
      make_site(480.0, {{.start = {west_m + 40.0, south_m + 240.0}, .length_m = 200.0, .width_m = 10.0},
                        {.start = {west_m + 40.0, south_m + 100.0}, .length_m = 200.0},
                        {.start = {west_m + 140.0, south_m + 240.0}, .heading_rad = 0.5 * pi, .length_m = 100.0}});
  EXPECT_EQ(rails_of(build_tile(site)), nullptr);
  site.roads.roads[0].highway = "motorway";
  const SceneTile tile = build_tile(site);
  const TriMesh* rails = rails_of(tile);
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
  const SceneTile tile = build_tile(site);
  const TriMesh* rails = rails_of(tile);
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

/// A ring of one-way roads in four quarters, counter-clockwise around its middle unless `clockwise`.
Site ring_site(double radius_m, bool clockwise, bool two_ways = false) {
  std::vector<RoadShape> shapes;
  const double turn = clockwise ? -1.0 : 1.0;
  for (int k = 0; k < 4; ++k) {
    const double angle = 0.5 * pi * k * turn;
    shapes.push_back(
        {.start = {west_m + 240.0 + radius_m * std::cos(angle), south_m + 240.0 + radius_m * std::sin(angle)},
         .heading_rad = angle + turn * 0.5 * pi,
         .length_m = 0.5 * pi * radius_m,
         .width_m = 8.0,
         .gradient = 0.0,
         .curvature_1pm = turn / radius_m});
  }
  Site site = make_site(480.0, shapes);
  for (roadquery::Road& road : site.roads.roads)
    if (!two_ways) road.sections[0].left.clear(), road.sections[0].right[0].width = {{.a = 5.0}};
  return site;
}

TEST(Structures, middles_of_roundabouts_have_a_kerb_along_the_inner_border) {
  const double radius_m = 14.0;
  const SceneTile tile = build_tile(ring_site(radius_m, false));
  const TriMesh* mesh = structure_of(tile);
  ASSERT_TRUE(mesh);
  double top = -1e9;
  std::set<int> seen_deg;
  for (const auto& position : mesh->positions) {
    const Vec3 p = world(tile, position);
    const double off_m = distance({p.x, p.y}, {west_m + 240.0, south_m + 240.0});
    EXPECT_LT(off_m, radius_m + 0.02) << "the lane lies outside";
    EXPECT_GT(off_m, radius_m - 0.15 - 0.03);
    top = std::max(top, p.z);
    seen_deg.insert(static_cast<int>(std::atan2(p.y - south_m - 240.0, p.x - west_m - 240.0) * 18.0 / pi));
  }
  EXPECT_NEAR(top, 10.0 + 0.12, 1e-4);
  EXPECT_GE(seen_deg.size(), 30U) << "all around";
}

TEST(Structures, blocks_between_streets_have_no_kerb) {
  EXPECT_EQ(structure_of(build_tile(ring_site(14.0, true))), nullptr) << "traffic has it on its right: no roundabout";
  EXPECT_EQ(structure_of(build_tile(ring_site(14.0, false, true))), nullptr) << "lanes of both directions";
  EXPECT_EQ(structure_of(build_tile(ring_site(60.0, false))), nullptr) << "larger than a roundabout";
}

}  // namespace
}  // namespace orthodrive::scene
