// SPDX-License-Identifier: Apache-2.0
// Roofs over footprints whose roof is known exactly.

#include "orthodrive/scene/buildings/roof.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "sanitized.hpp"

namespace orthodrive::scene {
namespace {

constexpr double pitch = 0.75, no_limit_m = 1e3;
const double stretch = std::sqrt(1.0 + pitch * pitch);  // area of a slope over its plan

Vec3 normal_of(const std::array<Vec3, 3>& t) {  // its length is twice the area
  const Vec3 a = t[1] - t[0], b = t[2] - t[0];
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(Vec3 v) { return std::hypot(v.x, v.y, v.z); }

double area_m2(const std::vector<std::array<Vec3, 3>>& triangles) {
  double sum = 0.0;
  for (const auto& t : triangles) sum += 0.5 * length(normal_of(t));
  return sum;
}

/// What holds for every roof: its slopes look up and cover the footprint once, every edge but the eaves has a partner.
void expect_roof(const Roof& roof, const Polygon& footprint) {
  double plan_m2 = 0.0, highest_m = 0.0;
  using Point = std::array<double, 3>;
  std::map<std::array<Point, 2>, int> edges;
  for (const auto* faces : {&roof.slopes, &roof.gables}) {
    for (const auto& t : *faces) {
      EXPECT_GT(length(normal_of(t)), 1e-4) << "a triangle without area";
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 a = t[k], b = t[(k + 1) % 3];
        ++edges[{Point{a.x, a.y, a.z}, Point{b.x, b.y, b.z}}];
        highest_m = std::max(highest_m, a.z);
      }
    }
  }
  for (const auto& t : roof.slopes) {
    EXPECT_GT(normal_of(t).z, 0.0);
    plan_m2 += 0.5 * normal_of(t).z;
  }
  EXPECT_NEAR(plan_m2, orthodrive::area_m2(footprint), 1e-6);
  EXPECT_NEAR(highest_m, roof.rise_m, 1e-6);
  double eaves_m = 0.0, border_m = 0.0;
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    if (edges.contains({edge[1], edge[0]})) continue;
    EXPECT_EQ(edge[0][2], 0.0);
    EXPECT_EQ(edge[1][2], 0.0);
    eaves_m += std::hypot(edge[1][0] - edge[0][0], edge[1][1] - edge[0][1]);
  }
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) border_m += distance(ring[i], ring[(i + 1) % ring.size()]);
  };
  add(footprint.outer);
  for (const Ring& hole : footprint.holes) add(hole);
  EXPECT_NEAR(eaves_m, border_m, 1e-6) << "open edges besides the eaves";
}

/// Every slope has the pitch: hipped roofs of footprints with right angles, on the grid.
void expect_hipped(const Polygon& footprint, double rise_m) {
  const Roof roof = make_roof(footprint, {.shape = RoofShape::hipped, .pitch = pitch, .max_rise_m = no_limit_m});
  EXPECT_EQ(roof.shape, RoofShape::hipped);
  EXPECT_NEAR(roof.rise_m, rise_m, 1e-9);
  EXPECT_NEAR(area_m2(roof.slopes), stretch * orthodrive::area_m2(footprint), 1e-6);
  for (const auto& t : roof.slopes) EXPECT_NEAR(normal_of(t).z / length(normal_of(t)), 1.0 / stretch, 1e-9);
  EXPECT_TRUE(roof.gables.empty());
  expect_roof(roof, footprint);
}

Polygon rectangle(double width_m, double depth_m) {
  return {{{0.0, 0.0}, {width_m, 0.0}, {width_m, depth_m}, {0.0, depth_m}}, {}};
}
const Polygon l_shape = {{{0, 0}, {12, 0}, {12, 4}, {4, 4}, {4, 10}, {0, 10}}, {}};
const Polygon u_shape = {{{0, 0}, {16, 0}, {16, 12}, {12, 12}, {12, 6}, {4, 6}, {4, 12}, {0, 12}}, {}};
const Polygon courtyard = {{{0, 0}, {20, 0}, {20, 18}, {0, 18}}, {{{6, 6}, {6, 12}, {14, 12}, {14, 6}}}};

TEST(Roof, gabled_over_a_rectangle_whichever_way_it_lies) {
  for (const auto& [width_m, depth_m] : {std::pair(10.0, 6.0), std::pair(6.0, 10.0)}) {
    const Roof roof =
        make_roof(rectangle(width_m, depth_m), {.shape = RoofShape::gabled, .pitch = pitch, .max_rise_m = no_limit_m});
    EXPECT_EQ(roof.shape, RoofShape::gabled);
    EXPECT_NEAR(roof.rise_m, 3.0 * pitch, 1e-12);
    EXPECT_NEAR(area_m2(roof.slopes), 60.0 * stretch, 1e-9);
    EXPECT_NEAR(area_m2(roof.gables), 6.0 * 3.0 * pitch, 1e-9);
    for (const auto& t : roof.gables) EXPECT_EQ(normal_of(t).z, 0.0);
    expect_roof(roof, rectangle(width_m, depth_m));
  }
}

TEST(Roof, gables_of_a_slanted_quadrilateral_stand_over_its_walls) {
  const Polygon slanted = {{{0.0, 0.0}, {10.0, 0.5}, {9.5, 6.5}, {0.5, 6.0}}, {}};
  const Roof roof = make_roof(slanted, {.shape = RoofShape::gabled, .pitch = pitch, .max_rise_m = no_limit_m});
  EXPECT_EQ(roof.shape, RoofShape::gabled);
  for (const auto& t : roof.gables) EXPECT_NEAR(normal_of(t).z, 0.0, 1e-12);
  expect_roof(roof, slanted);
}

TEST(Roof, other_footprints_than_rectangles_get_no_gables) {
  EXPECT_EQ(make_roof(l_shape, {.shape = RoofShape::gabled, .pitch = pitch, .max_rise_m = no_limit_m}).shape,
            RoofShape::hipped);
  const Polygon kite = {{{0, 0}, {5, -2}, {10, 0}, {5, 8}}, {}};
  EXPECT_EQ(make_roof(kite, {.shape = RoofShape::gabled, .pitch = pitch, .max_rise_m = no_limit_m}).shape,
            RoofShape::hipped);
}

TEST(Roof, hipped_over_rectangle_and_square) {
  expect_hipped(rectangle(10.0, 6.0), 3.0 * pitch);
  expect_hipped(rectangle(8.0, 8.0), 4.0 * pitch);  // a pyramid: all nodes of the skeleton are one
}

TEST(Roof, hipped_over_an_l_a_u_and_a_courtyard) {
  expect_hipped(l_shape, 2.0 * pitch);
  expect_hipped(u_shape, 3.0 * pitch);
  expect_hipped(courtyard, 3.0 * pitch);
}

TEST(Roof, a_limit_of_the_rise_makes_it_less_steep) {
  for (const RoofShape shape : {RoofShape::gabled, RoofShape::hipped}) {
    const Roof roof = make_roof(rectangle(40.0, 30.0), {.shape = shape, .pitch = pitch, .max_rise_m = 2.5});
    EXPECT_EQ(roof.shape, shape);
    EXPECT_NEAR(roof.rise_m, 2.5, 1e-9);
    expect_roof(roof, rectangle(40.0, 30.0));
  }
}

TEST(Roof, flat_covers_the_footprint_and_leaves_the_courtyard_open) {
  const Roof roof = make_roof(courtyard, {.shape = RoofShape::flat, .pitch = pitch, .max_rise_m = no_limit_m});
  EXPECT_EQ(roof.rise_m, 0.0);
  expect_roof(roof, courtyard);
}

Roof wished(const Polygon& footprint, const RoofWish& wish) {
  const Roof roof = make_roof(footprint, wish);
  EXPECT_EQ(roof.shape, wish.shape);
  expect_roof(roof, footprint);
  return roof;
}

double volume_m3(const Roof& roof) {
  double sum = 0.0;
  for (const auto& t : roof.slopes) sum += normal_of(t).z / 2.0 * (t[0].z + t[1].z + t[2].z) / 3.0;
  return sum;
}

TEST(Roof, profiles_hold_the_volume_under_them) {
  // Of a roof of 10 x 6 m that rises by 2 m: the profile's mean height.
  const auto volume_of = [](RoofShape shape) {
    return volume_m3(wished(rectangle(10.0, 6.0), {.shape = shape, .pitch = pitch, .rise_m = 2.0})) / (60.0 * 2.0);
  };
  EXPECT_NEAR(volume_of(RoofShape::gabled), 0.5, 1e-9);
  EXPECT_NEAR(volume_of(RoofShape::skillion), 0.5, 1e-9);
  EXPECT_NEAR(volume_of(RoofShape::saltbox), 0.5, 1e-9);
  EXPECT_NEAR(volume_of(RoofShape::gambrel), 2.0 * (0.2 * 0.3 + 0.3 * 0.8), 1e-9);
  EXPECT_NEAR(volume_of(RoofShape::round), 6.0 / 4.0 * std::sin(std::numbers::pi / 6.0), 1e-9)
      << "half of a regular polygon of twelve corners";
}

TEST(Roof, a_skillion_slopes_where_its_direction_says) {
  for (const auto& [down, x, y] : {std::tuple(Vec2{1.0, 0.2}, 0.0, 3.0), std::tuple(Vec2{-1.0, 0.0}, 10.0, 3.0),
                                   std::tuple(Vec2{0.1, 1.0}, 5.0, 0.0), std::tuple(Vec2{0.0, -1.0}, 5.0, 6.0)}) {
    const Roof roof =
        wished(rectangle(10.0, 6.0), {.shape = RoofShape::skillion, .pitch = pitch, .rise_m = 1.5, .downwards = down});
    for (const auto& t : roof.slopes)
      for (const Vec3& p : t) {
        const bool is_high = down.x * (p.x - 5.0) * 6.0 + down.y * (p.y - 3.0) * 10.0 < 0.0;
        EXPECT_EQ(p.z, is_high ? 1.5 : 0.0) << x << ' ' << y;
      }
  }
}

TEST(Roof, a_ridge_lies_across_where_the_map_says) {
  const Roof along = wished(rectangle(10.0, 6.0), {.shape = RoofShape::gabled, .pitch = pitch});
  const Roof across = wished(rectangle(10.0, 6.0), {.shape = RoofShape::gabled, .pitch = pitch, .ridge_across = true});
  EXPECT_NEAR(std::abs(along.ridge[0].x - along.ridge[1].x), 10.0, 1e-9);
  EXPECT_NEAR(std::abs(across.ridge[0].y - across.ridge[1].y), 6.0, 1e-9);
  EXPECT_NEAR(across.rise_m, 5.0 * pitch, 1e-9);
  const Roof by_direction =
      wished(rectangle(10.0, 6.0), {.shape = RoofShape::gabled, .pitch = pitch, .downwards = Vec2{0.9, 0.3}});
  EXPECT_NEAR(by_direction.rise_m, 5.0 * pitch, 1e-9);
}

TEST(Roof, half_hipped_has_gables_of_half_the_height) {
  const Roof roof = wished(rectangle(10.0, 6.0), {.shape = RoofShape::half_hipped, .pitch = pitch});
  EXPECT_NEAR(roof.rise_m, 3.0 * pitch, 1e-9);
  EXPECT_NEAR(area_m2(roof.gables), 2.0 * 0.5 * (6.0 + 3.0) * 0.5 * roof.rise_m, 1e-9);
  EXPECT_EQ(make_roof(l_shape, {.shape = RoofShape::half_hipped}).shape, RoofShape::hipped);
}

TEST(Roof, pyramids_domes_and_onions_rise_around_the_middle) {
  Polygon round;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 24.0;
    round.outer.push_back(snap_to_grid({5.0 * std::cos(angle), 5.0 * std::sin(angle)}));
  }
  const double base_m2 = orthodrive::area_m2(round);
  const Roof cone = wished(round, {.shape = RoofShape::pyramidal, .pitch = pitch, .rise_m = 6.0});
  EXPECT_NEAR(volume_m3(cone), base_m2 * 6.0 / 3.0, 1e-6);
  const Roof dome = wished(round, {.shape = RoofShape::dome});
  EXPECT_NEAR(dome.rise_m, std::sqrt(base_m2 / std::numbers::pi), 1e-9);
  EXPECT_NEAR(volume_m3(dome), base_m2 * dome.rise_m * 2.0 / 3.0, 0.06 * base_m2 * dome.rise_m) << "half a ball";
  const Roof onion = make_roof(round, {.shape = RoofShape::onion, .rise_m = 8.0});
  EXPECT_EQ(onion.shape, RoofShape::onion);
  double widest_m = 0.0;
  for (const auto& t : onion.slopes)
    for (const Vec3& p : t) widest_m = std::max(widest_m, std::hypot(p.x, p.y));
  EXPECT_NEAR(widest_m, 5.6, 0.01) << "it bulges";
  EXPECT_EQ(make_roof(u_shape, {.shape = RoofShape::dome}).shape, RoofShape::hipped) << "its middle lies outside";
}

TEST(Roof, a_mansard_is_steep_below_and_hipped_above) {
  for (const Polygon& footprint : {rectangle(16.0, 12.0), l_shape}) {
    const Roof roof = wished(footprint, {.shape = RoofShape::mansard, .pitch = pitch, .rise_m = 4.0});
    EXPECT_NEAR(roof.rise_m, 4.0, 1e-9);
    EXPECT_GT(volume_m3(roof), 0.5 * 4.0 * orthodrive::area_m2(footprint));
  }
}

TEST(Roof, names_of_osm) {
  EXPECT_EQ(roof_shape_of("half-hipped"), RoofShape::half_hipped);
  EXPECT_EQ(roof_shape_of("cone"), RoofShape::pyramidal);
  EXPECT_FALSE(roof_shape_of("střecha"));
}

TEST(Roof, self_touching_footprints_are_flat) {
  // Two squares that meet in a corner, and a courtyard whose corner touches the wall.
  const Polygon bow = {{{0, 0}, {4, 0}, {4, 4}, {8, 4}, {8, 8}, {4, 8}, {4, 4}, {0, 4}}, {}};
  const Polygon touching = {{{0, 0}, {5, 0}, {10, 0}, {10, 10}, {0, 10}}, {{{5, 0}, {3, 3}, {5, 6}, {7, 3}}}};
  for (const Polygon& footprint : {bow, touching}) {
    const Roof roof = make_roof(footprint, {.shape = RoofShape::hipped, .pitch = pitch, .max_rise_m = no_limit_m});
    EXPECT_EQ(roof.shape, RoofShape::flat);
    double plan_m2 = 0.0;
    for (const auto& t : roof.slopes) plan_m2 += 0.5 * normal_of(t).z;
    EXPECT_NEAR(plan_m2, orthodrive::area_m2(footprint), 1e-9);
  }
}

TEST(Roof, of_ten_thousand_corners_is_flat) {
  Polygon gear;
  for (int i = 0; i < 10000; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 10000.0, r = i % 2 == 0 ? 50.0 : 48.0;
    gear.outer.push_back(snap_to_grid({r * std::cos(angle), r * std::sin(angle)}));
  }
  const Roof roof = make_roof(gear, {.shape = RoofShape::hipped, .pitch = pitch, .max_rise_m = no_limit_m});
  EXPECT_EQ(roof.shape, RoofShape::flat);
  EXPECT_EQ(roof.slopes.size(), 9998U);
}

/// Any union of turned boxes: no crash, no gap, no triangle without area; most get the roof they are asked for.
TEST(Roof, of_random_footprints_are_roofs) {
  int sloped = 0, all = 0;
  for (int seed = 0; seed < 300; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
    std::vector<Polygon> boxes;
    for (std::uint64_t k = 0; k < 1 + random.below(4); ++k) {
      const Vec2 at{random.uniform(-6.0, 6.0), random.uniform(-6.0, 6.0)};
      const double w = random.uniform(4.0, 9.0), d = random.uniform(4.0, 9.0);
      Polygon box;
      for (const Vec2 c : {Vec2{-w, -d}, Vec2{w, -d}, Vec2{w, d}, Vec2{-w, d}}) {
        const Vec2 p = at + c;
        box.outer.push_back({p.x * std::cos(turn) - p.y * std::sin(turn), p.x * std::sin(turn) + p.y * std::cos(turn)});
      }
      boxes.push_back(box);
    }
    for (const Polygon& footprint : union_of(boxes, plan_grid_m)) {
      SCOPED_TRACE(seed);
      const Roof roof = make_roof(footprint, {.shape = RoofShape::gabled, .pitch = pitch, .max_rise_m = 4.0});
      ++all;
      sloped += roof.shape != RoofShape::flat ? 1 : 0;
      expect_roof(roof, footprint);
    }
  }
  EXPECT_GT(sloped, all * 90 / 100) << "nearly coincident nodes make lines cross: those are flat";
}

class EveryRoofShape : public testing::TestWithParam<RoofShape> {};

/// Whatever a map asks for over whatever footprint: closed, no triangle without area, the rise that was asked for.
TEST_P(EveryRoofShape, over_random_footprints_is_closed) {
  for (int seed = 0; seed < 120; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
    Polygon footprint;
    const double w = random.uniform(3.0, 15.0), d = random.uniform(3.0, 15.0), notch = random.uniform(0.0, 0.4);
    const std::vector<Vec2> corners = seed % 3 == 0 ? std::vector<Vec2>{{0, 0}, {w, 0}, {w, d}, {0, d}}
                                                    : std::vector<Vec2>{{0, 0},
                                                                        {w, 0},
                                                                        {w, d * (1.0 - notch)},
                                                                        {w * (1.0 - notch), d * (1.0 - notch)},
                                                                        {w * (1.0 - notch), d},
                                                                        {0, d}};
    for (const Vec2 p : corners)
      footprint.outer.push_back(
          snap_to_grid({p.x * std::cos(turn) - p.y * std::sin(turn), p.x * std::sin(turn) + p.y * std::cos(turn)}));
    for (const Polygon& clean : union_of(std::span(&footprint, 1), plan_grid_m)) {
      SCOPED_TRACE(seed);
      const Roof roof = make_roof(clean, {.shape = GetParam(), .rise_m = 2.5});
      if (roof.shape != RoofShape::onion) {
        expect_roof(roof, clean);
      }
      if (roof.shape != RoofShape::flat) {
        EXPECT_NEAR(roof.rise_m, 2.5, 0.1);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Roof, EveryRoofShape,
                         testing::Values(RoofShape::flat, RoofShape::skillion, RoofShape::gabled,
                                         RoofShape::half_hipped, RoofShape::hipped, RoofShape::pyramidal,
                                         RoofShape::gambrel, RoofShape::mansard, RoofShape::saltbox, RoofShape::round,
                                         RoofShape::dome, RoofShape::onion),
                         [](const auto& info) { return "shape_" + std::to_string(static_cast<int>(info.param)); });

/// A house of Pardubice whose skeleton has many events at one time: what CGAL makes of them depends on addresses.
TEST(Roof, of_a_symmetric_footprint_depends_on_no_address) {
  const Polygon footprint{{{-7.955078125, -2.65234375},
                           {-4.4189453125, -6.1875},
                           {-2.6513671875, -4.419921875},
                           {-0.8837890625, -6.1875},
                           {0.8837890625, -4.419921875},
                           {2.6513671875, -6.1875},
                           {7.955078125, -0.884765625},
                           {6.1875, 0.8837890625},
                           {7.955078125, 2.6513671875},
                           {4.419921875, 6.1865234375},
                           {2.6513671875, 4.4189453125},
                           {0.8837890625, 6.1865234375},
                           {-0.8837890625, 4.4189453125},
                           {-2.6513671875, 6.1865234375},
                           {-7.955078125, 0.8837890625},
                           {-6.1875, -0.884765625}},
                          {}};
  const RoofWish wish{.shape = RoofShape::hipped, .max_rise_m = 2.8};
  const Roof expected = make_roof(footprint, wish);
  ASSERT_EQ(expected.shape, RoofShape::hipped);
  Random random(3);
  std::vector<std::unique_ptr<char[]>> between;
  for (int i = 0; i < (sanitized ? 30 : 300); ++i) {
    between.push_back(std::make_unique<char[]>(static_cast<std::size_t>(random.uniform(1.0, 3000.0))));
    if (i % 3 == 0) between.erase(between.begin() + static_cast<std::ptrdiff_t>(between.size() / 2));
    const Roof roof = make_roof(footprint, wish);
    ASSERT_EQ(roof.rise_m, expected.rise_m);
    ASSERT_EQ(roof.slopes.size(), expected.slopes.size());
    for (std::size_t k = 0; k < roof.slopes.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 a = roof.slopes[k][c], b = expected.slopes[k][c];
        ASSERT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z) << "roof " << i << ", slope " << k;
      }
  }
}

}  // namespace
}  // namespace orthodrive::scene
