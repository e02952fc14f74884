// SPDX-License-Identifier: Apache-2.0
// Tunnels and decks: what lies over and beside them, and that their roads go on in those on the ground without a crack.

#include "orthodrive/scene/structures/tunnels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/scene/tiles/coarse_tile.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "sanitized.hpp"
#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using namespace scene_test;

constexpr TileAddress tile_address = {1000, 13000};
constexpr double from_m = 160.0, to_m = 320.0, north_m = 240.0, floor_z = 10.0, half_width_m = 3.0;

/// A plain at 10 m and a hill of 25 m with slopes of 45 degrees that begin at both ends of the tunnel.
double hill_m(Vec2 p) {
  const double in_m = std::min(p.x - west_m - from_m, west_m + to_m - p.x);
  return floor_z + std::clamp(in_m, 0.0, 25.0);
}

/// Links road i's end to road i + 1's start.
Site in_a_row(Site site) {
  auto& roads = site.roads.roads;
  for (std::size_t i = 0; i + 1 < roads.size(); ++i) {
    roads[i].successor = {roadquery::LinkKind::road, roads[i + 1].id, roadquery::ContactPoint::start};
    roads[i + 1].predecessor = {roadquery::LinkKind::road, roads[i].id, roadquery::ContactPoint::end};
  }
  return site;
}

Site hill_site(const std::function<double(Vec2)>& height_m = hill_m) {
  return in_a_row(make_site(480.0,
                            {{.start = {west_m + 40.0, south_m + north_m}, .length_m = 120.0, .z_m = floor_z},
                             {.start = {west_m + from_m, south_m + north_m},
                              .length_m = to_m - from_m,
                              .z_m = floor_z,
                              .layer = -1,
                              .tunnel = true},
                             {.start = {west_m + to_m, south_m + north_m}, .length_m = 120.0, .z_m = floor_z}},
                            height_m));
}

TEST(Tunnels, no_ground_lies_in_the_clear_section) {
  const SceneTile tile = build_scene_tile(*lay_out_scene(hill_site().input()), tile_address);
  const TriMesh &terrain = *find_mesh(tile, MeshKind::terrain), &road = *find_mesh(tile, MeshKind::tunnel_road);
  int opened = 0, covered = 0;
  for (double x = from_m + 0.05; x < to_m; x += sanitized ? 2.1 : 0.7) {
    for (double y = -half_width_m; y <= half_width_m; y += sanitized ? 1.0 : 0.5) {
      const Vec2 p{west_m + x, south_m + north_m + y * 0.999};
      EXPECT_NEAR(mesh_height_m(tile, road, p), floor_z, 1e-5) << "the road goes on";
      const double z = mesh_height_m(tile, terrain, p);
      if (std::isnan(z)) {
        ++opened;
      } else {
        EXPECT_GT(z, floor_z + 3.8) << x << ' ' << y;
        ++covered;
      }
    }
  }
  EXPECT_GT(opened, sanitized ? 8 : 50);
  EXPECT_GT(covered, 10 * opened);
}

TEST(Tunnels, walls_and_vault_stay_out_of_the_clear_section) {
  const SceneTile tile = build_scene_tile(*lay_out_scene(hill_site().input()), tile_address);
  const TriMesh* tube = find_mesh(tile, MeshKind::tunnel);
  ASSERT_TRUE(tube);
  int inside = 0;
  double top = -1e9;
  for (std::size_t i = 0; i < tube->indices.size(); i += 3) {
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = world(tile, tube->positions[tube->indices[i + k]]);
    for (int u = 0; u <= 12; ++u)
      for (int v = 0; u + v <= 12; ++v) {
        const Vec3 p = c[0] + (c[1] - c[0]) * (u / 12.0) + (c[2] - c[0]) * (v / 12.0);
        const double beside = std::abs(p.y - south_m - north_m), over = p.z - floor_z;
        top = std::max(top, over);
        inside += static_cast<int>(beside < half_width_m - 0.05 && over > 0.0 && over < 3.75);
      }
  }
  EXPECT_EQ(inside, 0);
  EXPECT_GT(top, 4.7) << "portals rise over the vault";
}

TEST(Tunnels, portals_stand_where_the_hill_covers_the_vault) {
  const SceneTile tile = build_scene_tile(*lay_out_scene(hill_site().input()), tile_address);
  const TriMesh& tube = *find_mesh(tile, MeshKind::tunnel);
  std::set<double> across;  // places of faces that look along the road and are higher than the vault
  for (std::size_t i = 0; i < tube.indices.size(); i += 3) {
    if (std::abs(tube.normals[tube.indices[i]][0]) < 0.99F) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = world(tile, tube.positions[tube.indices[i + k]]);
      if (p.z > floor_z + 4.0) across.insert(std::round(p.x - west_m));
    }
  }
  ASSERT_GE(across.size(), 2U);
  EXPECT_NEAR(*across.begin(), from_m + 5.0, 2.1) << "4.2 m of ground above the road, which the verge still lowers";
  EXPECT_NEAR(*across.rbegin(), to_m - 5.0, 2.1);
}

TEST(Tunnels, the_ground_above_is_the_terrain_model) {
  const Site site = hill_site();
  const auto layout = lay_out_scene(site.input());
  const SceneTile tile = build_scene_tile(*layout, tile_address);
  int above = 0;
  for (const auto& position : find_mesh(tile, MeshKind::terrain)->positions) {
    const Vec3 p = world(tile, position);
    if (p.x < west_m + from_m + 5.0 || p.x > west_m + to_m - 5.0) continue;
    EXPECT_NEAR(p.z, layout->ground->terrain_m({p.x, p.y}), 1e-5);
    ++above;
  }
  EXPECT_GT(above, 300);
  EXPECT_TRUE(scene_findings(*layout).empty());
}

/// Edges of the meshes, by positions with heights, with a middle that `counts`.
using Edge = std::array<std::array<float, 3>, 2>;
std::set<Edge> edges_of(const SceneTile& tile, std::initializer_list<MeshKind> kinds,
                        const std::function<bool(Vec2)>& counts) {
  std::set<Edge> edges;
  for (const MeshKind kind : kinds) {
    const TriMesh* mesh = find_mesh(tile, kind);
    if (mesh == nullptr) continue;
    for (std::size_t i = 0; i < mesh->indices.size(); i += 3)
      for (std::size_t k = 0; k < 3; ++k) {
        const Edge edge{mesh->positions[mesh->indices[i + k]], mesh->positions[mesh->indices[i + (k + 1) % 3]]};
        const Vec3 a = world(tile, edge[0]), b = world(tile, edge[1]);
        if (counts({0.5 * (a.x + b.x), 0.5 * (a.y + b.y)})) edges.insert(edge);
      }
  }
  return edges;
}

/// Edges without one in the other direction.
int open_edges(const std::set<Edge>& edges) {
  return static_cast<int>(std::ranges::count_if(edges, [&](const Edge& e) { return !edges.contains({e[1], e[0]}); }));
}

/// Slanted, with gradient, banking, a crown and another width on one side: nothing is alike by accident.
Site slanted_row(bool is_tunnel) {
  const double heading = 0.37, gradient = 0.043;
  const auto place = [&](double s) {
    return Vec2{west_m + 60.3 + s * std::cos(heading), south_m + 70.7 + s * std::sin(heading)};
  };
  const auto shape = [&](double from, double length, double width, bool middle) {
    return RoadShape{.start = place(from),
                     .heading_rad = heading,
                     .length_m = length,
                     .width_m = width,
                     .z_m = 12.0 + gradient * from,
                     .gradient = gradient,
                     .superelevation_rad = 0.021,
                     .layer = middle ? (is_tunnel ? -1 : 1) : 0,
                     .bridge = middle && !is_tunnel,
                     .tunnel = middle && is_tunnel};
  };
  const auto height = [&](Vec2 p) {
    const double s = (p.x - west_m - 60.3) * std::cos(heading) + (p.y - south_m - 70.7) * std::sin(heading);
    const double in_m = std::min(s - 110.0, 250.0 - s);
    return 12.0 + gradient * s + (is_tunnel ? 1.0 : -1.0) * std::clamp(0.8 * in_m, 0.0, 14.0);
  };
  Site site = in_a_row(make_site(
      480.0, {shape(0.0, 110.0, 7.3, false), shape(110.0, 140.0, 6.1, true), shape(250.0, 110.0, 9.7, false)}, height));
  for (roadquery::Road& road : site.roads.roads) {
    road.shape.push_back({0.0, -30.0, -30.0 * 0.025, 0.025, 0.0, 0.0});
    road.shape.push_back({0.0, 0.0, 0.0, -0.025, 0.0, 0.0});
  }
  return site;
}

void expect_joined(bool is_tunnel) {
  const SceneTile tile = build_scene_tile(*lay_out_scene(slanted_row(is_tunnel).input()), tile_address);
  const double heading = 0.37;
  // The cross section is pitched by the slope: its right edge, 14 cm below the line, lies 6 mm ahead of it.
  constexpr double off_m = 3e-3 + 6e-3;
  int shared = 0;
  for (const double s : {110.0, 250.0}) {
    const Vec2 joint{west_m + 60.3 + s * std::cos(heading), south_m + 70.7 + s * std::sin(heading)};
    // The narrowest of both roads there is 6.1 m wide. Edges on the joint: their middle lies on it, and both ends do.
    const auto along_m = [&](Vec2 p) {
      return std::abs((p.x - joint.x) * std::cos(heading) + (p.y - joint.y) * std::sin(heading));
    };
    std::set<Edge> edges = edges_of(tile, {MeshKind::road, MeshKind::tunnel_road},
                                    [&](Vec2 p) { return along_m(p) < off_m && distance(p, joint) < 3.04; });
    std::erase_if(edges, [&](const Edge& e) {
      const Vec3 a = world(tile, e[0]), b = world(tile, e[1]);
      return along_m({a.x, a.y}) > off_m || along_m({b.x, b.y}) > off_m;
    });
    EXPECT_EQ(open_edges(edges), 0) << s;
    shared += static_cast<int>(edges.size()) / 2;
  }
  EXPECT_GE(shared, 4) << "at least two at each joint: there is a ridge";
}

TEST(Tunnels, roads_in_tunnels_share_the_vertices_of_joints_with_those_on_the_ground) { expect_joined(true); }

TEST(Decks, share_the_vertices_of_joints_with_roads_on_the_ground) { expect_joined(false); }

TEST(Decks, joint_across_a_tile_border_is_the_same_from_both_sides) {
  const double heading = 1.4;
  const Vec2 joint{west_m + 479.3, south_m + 200.0}, along{std::cos(heading), std::sin(heading)};
  const Site site = in_a_row(make_site(960.0, {{.start = joint - along * 100.0,
                                                .heading_rad = heading,
                                                .length_m = 100.0,
                                                .z_m = 12.0,
                                                .gradient = 0.03,
                                                .superelevation_rad = 0.03},
                                               {.start = joint,
                                                .heading_rad = heading,
                                                .length_m = 100.0,
                                                .z_m = 15.0,
                                                .gradient = 0.03,
                                                .superelevation_rad = 0.03,
                                                .layer = 1,
                                                .bridge = true}}));
  const auto layout = lay_out_scene(site.input());
  std::set<std::array<double, 3>> west, east;
  for (const bool is_east : {false, true}) {
    const SceneTile tile = build_scene_tile(*layout, {is_east ? 1001 : 1000, 13000});
    std::set<Edge> edges = edges_of(tile, {MeshKind::road}, [&](Vec2 p) { return distance(p, joint) < 3.04; });
    std::erase_if(edges, [&](const Edge& e) {
      return std::ranges::any_of(e, [&](const auto& end) {
        const Vec3 p = world(tile, end);
        return std::abs(dot(along, Vec2{p.x, p.y} - joint)) > 3e-3;
      });
    });
    EXPECT_GE(edges.size(), 2U);
    EXPECT_EQ(open_edges(edges), 0);
    for (const auto& position : find_mesh(tile, MeshKind::road)->positions) {
      const Vec3 p = world(tile, position);
      if (p.x == west_m + 480.0) (is_east ? east : west).insert({p.x, p.y, p.z});
    }
  }
  EXPECT_GE(west.size(), 3U);
  EXPECT_EQ(west, east);
}

TEST(Tunnels, cross_tile_borders_with_the_same_vertices) {
  const auto hill = [](Vec2 p) {
    return 10.0 + std::clamp(0.5 * (150.0 - distance(p, {west_m + 480.0, south_m + 243.0})), 0.0, 40.0);
  };
  const double heading = 0.11;
  const auto at = [&](double s) {
    return Vec2{west_m + 480.0 + s * std::cos(heading), south_m + 243.0 + s * std::sin(heading)};
  };
  const Site site =
      in_a_row(make_site(960.0,
                         {{.start = at(-300.0), .heading_rad = heading, .length_m = 150.0},
                          {.start = at(-150.0), .heading_rad = heading, .length_m = 300.0, .layer = -1, .tunnel = true},
                          {.start = at(150.0), .heading_rad = heading, .length_m = 150.0}},
                         hill));
  const auto layout = lay_out_scene(site.input());
  std::set<std::array<double, 3>> west, east;
  for (const bool is_east : {false, true}) {
    const SceneTile tile = build_scene_tile(*layout, {is_east ? 1001 : 1000, 13000});
    expect_upwards(*find_mesh(tile, MeshKind::tunnel_road));
    for (const auto& position : find_mesh(tile, MeshKind::tunnel_road)->positions) {
      const Vec3 p = world(tile, position);
      if (p.x == west_m + 480.0) (is_east ? east : west).insert({p.x, p.y, p.z});
    }
  }
  EXPECT_GE(west.size(), 2U);
  EXPECT_EQ(west, east);
}

TEST(Tunnels, without_cover_are_open_cuttings_and_found) {
  const Site site = hill_site([](Vec2 p) { return floor_z + (std::abs(p.x - west_m - 240.0) < 80.0 ? 2.0 : 0.0); });
  const auto layout = lay_out_scene(site.input());
  ASSERT_EQ(scene_findings(*layout).size(), 1U);
  EXPECT_EQ(scene_findings(*layout)[0].code, "scene.tunnel_without_cover");
  EXPECT_NEAR(scene_findings(*layout)[0].x_m, west_m + from_m + 15.0, 2.1);
  const SceneTile tile = build_scene_tile(*layout, tile_address);
  for (double x = from_m + 0.5; x < to_m; x += 5.1)
    EXPECT_TRUE(
        std::isnan(mesh_height_m(tile, *find_mesh(tile, MeshKind::terrain), {west_m + x, south_m + north_m + 3.4})));
  for (const auto& position : find_mesh(tile, MeshKind::tunnel)->positions)
    EXPECT_LT(world(tile, position).z, floor_z + 2.0 + 0.31) << "no vault, but walls";
}

TEST(Tunnels, below_a_road_have_a_roof_also_without_ground_above) {
  // An underpass: the road above lies on the plain, 4.9 m over the one below in its cutting.
  Site site =
      in_a_row(make_site(480.0,
                         {{.start = {west_m + 140.0, south_m + north_m}, .length_m = 90.0, .z_m = 5.1},
                          {.start = {west_m + 230.0, south_m + north_m}, .length_m = 20.0, .z_m = 5.1, .tunnel = true},
                          {.start = {west_m + 250.0, south_m + north_m}, .length_m = 90.0, .z_m = 5.1}},
                         [](Vec2 p) { return std::abs(p.y - south_m - north_m) < 8.0 ? 5.1 : 10.0; }));
  site.roads.roads.push_back(
      make_road(9, {.start = {west_m + 240.0, south_m + 40.0}, .heading_rad = 1.5707963, .length_m = 400.0}));
  const SceneTile tile = build_scene_tile(*lay_out_scene(site.input()), tile_address);
  const TriMesh &tube = *find_mesh(tile, MeshKind::tunnel), &road = *find_mesh(tile, MeshKind::road);
  int vault = 0;
  for (std::size_t i = 0; i < tube.indices.size(); i += 3) {
    if (tube.normals[tube.indices[i]][2] > -0.9F) continue;
    const Vec3 p = world(tile, tube.positions[tube.indices[i]]);
    EXPECT_GE(p.z, 5.1 + 3.8 - 1e-4);
    EXPECT_LE(p.z, 10.0 - 0.4 + 1e-4) << "a slab below the road above";
    vault += static_cast<int>(std::abs(p.x - west_m - 240.0) < 2.0);
  }
  EXPECT_GE(vault, 2) << "also in the middle";
  for (double y = -20.0; y <= 20.0; y += 1.3)
    EXPECT_NEAR(mesh_height_m(tile, road, {west_m + 240.3, south_m + north_m + y}), 10.0, 1e-4) << y;
}

TEST(Tunnels, openings_are_ground_again_from_afar) {
  const SceneTile tile = build_scene_tile(*lay_out_scene(hill_site().input()), tile_address);
  const double fine_m2 = scene_test::plan_area_m2(find_mesh(tile, MeshKind::terrain)) +
                         scene_test::plan_area_m2(find_mesh(tile, MeshKind::road));
  EXPECT_LT(fine_m2, 480.0 * 480.0 - 60.0) << "two openings, 7.5 m wide and at least 4 m long";
  EXPECT_NEAR(fine_m2 + scene_test::plan_area_m2(&tile.lids), 480.0 * 480.0, 1e-3);
  const SceneTile ready = ready_to_coarsen(tile);
  EXPECT_GT(ready.geometric_error_m, 4.0) << "as high as the portals";
  const std::vector<const SceneTile*> tiles = {&ready};
  const SceneTile coarse = coarse_tile(tiles, {});
  EXPECT_EQ(find_mesh(coarse, MeshKind::tunnel), nullptr);
  EXPECT_EQ(find_mesh(coarse, MeshKind::tunnel_road), nullptr);
  EXPECT_NEAR(scene_test::plan_area_m2(find_mesh(coarse, MeshKind::terrain)) +
                  scene_test::plan_area_m2(find_mesh(coarse, MeshKind::road)),
              480.0 * 480.0, 1e-3)
      << "without a gap";
}

TEST(Tunnels, ground_opens_only_along_walls_and_roads) {
  const Site site = hill_site();
  const auto layout = lay_out_scene(site.input());
  const SceneTile tile = build_scene_tile(*layout, tile_address);
  expect_closed(tile, [&](Vec2 a, Vec2 b) {
    const bool at_opening =
        layout->openings.nearest(a).distance_m < 2e-3 && layout->openings.nearest(b).distance_m < 2e-3;
    return at_opening || on_tile_border(a, b);
  });
}

}  // namespace
}  // namespace orthodrive::scene
