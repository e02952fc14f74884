// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/kerbs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "roadquery/query/road_query.hpp"
#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using namespace scene_test;

/// 6 m of carriageway and a walk of 2 m on the right: flat for a metre, then up to 12 cm within another one; down again
/// to the end.
roadquery::Road road_with_walk(const RoadShape& shape) {
  roadquery::Road road = make_road(1, shape);
  roadquery::Lane walk{.id = -2, .type = roadquery::LaneType::sidewalk, .width = {{.a = 2.0}}};
  walk.heights = {{1.0, 0.0, 0.0}, {2.0, 0.12, 0.12}, {shape.length_m - 1.0, 0.12, 0.12}, {shape.length_m, 0.0, 0.0}};
  road.sections[0].right.push_back(walk);
  return road;
}

double area_m2(const KerbPiece& piece) {
  const auto& c = piece.corners;
  return 0.5 * (cross(c[1] - c[0], c[2] - c[0]) + cross(c[2] - c[0], c[3] - c[0]));
}

TEST(Kerbs, pieces_cover_the_raised_lane_with_a_stone_along_the_carriageway) {
  const auto pieces = kerb_pieces(road_with_walk({.start = {0.0, 0.0}}));
  double stone = 0.0, walk = 0.0;
  for (const KerbPiece& piece : pieces) {
    EXPECT_GT(area_m2(piece), 0.0) << "counter-clockwise";
    (piece.look == KerbLook::stone ? stone : walk) += area_m2(piece);
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 p = piece.corners[i];
      EXPECT_NEAR(piece.lift_m[i], 0.12 * std::clamp(std::min(p.x - 1.0, 100.0 - p.x), 0.0, 1.0), 1e-9) << p.x;
      EXPECT_LE(p.y, -3.0 + 1e-9);
      EXPECT_GE(p.y, -5.0 - 1e-9);
    }
  }
  EXPECT_NEAR(stone, 99.0 * kerb_stone_m, 1e-9) << "not where the walk is flat";
  EXPECT_NEAR(walk, 99.0 * (2.0 - kerb_stone_m), 1e-9);
  roadquery::Road flat = road_with_walk({.start = {0.0, 0.0}});
  flat.sections[0].right[1].heights.clear();
  EXPECT_TRUE(kerb_pieces(flat).empty());
}

TEST(Kerbs, left_walks_have_their_stone_at_the_carriageway_too) {
  roadquery::Road road = road_with_walk({.start = {0.0, 0.0}, .curvature_1pm = 0.02});
  roadquery::Lane walk = road.sections[0].right.back();
  road.sections[0].right.pop_back();
  walk.id = 2;
  road.sections[0].left.push_back(walk);
  for (const KerbPiece& piece : kerb_pieces(road)) {
    EXPECT_GT(area_m2(piece), 0.0);
    const Vec2 middle = (piece.corners[0] + piece.corners[2]) * 0.5;
    const double inside_m = 50.0 - distance(middle, {0.0, 50.0});
    EXPECT_EQ(piece.look == KerbLook::stone, inside_m < 3.2) << inside_m;
  }
}

/// Height of the kerb mesh's flat parts over p, or nothing.
std::optional<double> top_at(const SceneTile& tile, const TriMesh& mesh, Vec2 p) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    if (mesh.normals[mesh.indices[i]][2] < 0.5F) continue;
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = world(tile, mesh.positions[mesh.indices[i + k]]);
    const auto side = [&](std::size_t a, std::size_t b) {
      return cross(Vec2{c[b].x - c[a].x, c[b].y - c[a].y}, p - Vec2{c[a].x, c[a].y});
    };
    const double u = side(1, 2), v = side(2, 0), w = side(0, 1);
    if (u < 0.0 || v < 0.0 || w < 0.0) continue;
    return (u * c[0].z + v * c[1].z + w * c[2].z) / (u + v + w);
  }
  return std::nullopt;
}

Site site_with_walk(const RoadShape& shape) {
  Site site = make_site(480.0, {shape});
  site.roads.roads[0] = road_with_walk(shape);
  return site;
}

TEST(Kerbs, what_is_seen_is_what_is_driven) {
  const RoadShape shape{.start = {west_m + 100.0, south_m + 150.0},
                        .heading_rad = 0.4,
                        .length_m = 150.0,
                        .gradient = 0.03,
                        .curvature_1pm = 0.008,
                        .superelevation_rad = 0.02};
  const Site site = site_with_walk(shape);
  const auto layout = lay_out_scene(site.input());
  const SceneTile tile = build_scene_tile(*layout, {1000, 13000});
  const TriMesh* kerb = find_mesh(tile, MeshKind::kerb);
  ASSERT_TRUE(kerb);
  const roadquery::RoadQuery query(site.roads);
  int compared = 0;
  for (double s = 2.5; s < 148.0; s += 3.7)
    for (const double t : {-3.05, -3.4, -4.8}) {
      const auto p = roadquery::surface_point(site.roads.roads[0], s, t);
      roadquery::Cursor cursor;
      const auto hit = query.find(p.x, p.y, p.z, cursor);
      const auto z = top_at(tile, *kerb, {p.x, p.y});
      ASSERT_TRUE(hit && z) << s << ' ' << t;
      EXPECT_NEAR(*z, hit->z, 0.02) << s << ' ' << t;
      ++compared;
    }
  EXPECT_GT(compared, 100);
  const auto road = roadquery::surface_point(site.roads.roads[0], 75.0, -2.9);
  EXPECT_FALSE(top_at(tile, *kerb, {road.x, road.y})) << "nothing lies on the driving lane";
}

TEST(Kerbs, faces_stand_upright_between_road_and_top_and_look_outwards) {
  const Site site = site_with_walk({.start = {west_m + 100.0, south_m + 240.0}, .length_m = 50.0});
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), {1000, 13000});
  const TriMesh* kerb = find_mesh(tile, MeshKind::kerb);
  ASSERT_TRUE(kerb);
  double inner_m2 = 0.0, outer_m2 = 0.0;
  for (std::size_t i = 0; i < kerb->indices.size(); i += 3) {
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = world(tile, kerb->positions[kerb->indices[i + k]]);
    const auto& n = kerb->normals[kerb->indices[i]];
    const Vec3 a = c[1] - c[0], b = c[2] - c[0];
    const Vec3 area{0.5 * (a.y * b.z - a.z * b.y), 0.5 * (a.z * b.x - a.x * b.z), 0.5 * (a.x * b.y - a.y * b.x)};
    EXPECT_GT(area.x * n[0] + area.y * n[1] + area.z * n[2], 0.0) << "turned as its normal says";
    if (std::abs(n[2]) > 0.5F) continue;
    if (std::abs(n[1]) < 0.5F) continue;
    (n[1] > 0.0F ? inner_m2 : outer_m2) += std::abs(area.y);
    EXPECT_NEAR(c[0].y, south_m + (n[1] > 0.0F ? 237.0 : 235.0), 1e-3);
  }
  const double area = 47.0 * 0.12 + 2.0 * 0.5 * 0.12;  // with the ramps, and 3 cm that lie in the road
  EXPECT_NEAR(inner_m2, area + 49.0 * 0.03, 0.02);
  EXPECT_NEAR(outer_m2, inner_m2, 1e-3);
}

TEST(Kerbs, tiles_share_them_without_overlap) {
  const RoadShape shape{.start = {west_m + 400.0, south_m + 100.0}, .heading_rad = 0.2, .length_m = 160.0};
  Site site = make_site(960.0, {shape});
  site.roads.roads[0] = road_with_walk(shape);
  const auto layout = lay_out_scene(site.input());
  double top_m2 = 0.0;
  for (const TileAddress address : scene_tiles(*layout)) {
    const SceneTile tile = build_scene_tile(*layout, address);
    if (const TriMesh* kerb = find_mesh(tile, MeshKind::kerb)) top_m2 += plan_area_m2(kerb);
  }
  EXPECT_NEAR(top_m2, 159.0 * 2.0, 0.5);
}

}  // namespace
}  // namespace orthodrive::scene
