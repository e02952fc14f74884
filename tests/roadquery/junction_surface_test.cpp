// SPDX-License-Identifier: Apache-2.0
// The surface of a junction as exact functions: planes, quadratic fields, arms with a crown.

#include "roadquery/surface/junction_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "roadquery/make_road.hpp"
#include "roadquery/surface/short_ways.hpp"

namespace roadquery {
namespace {

using test::make_road;

JunctionSurface field_of(const std::function<double(double, double)>& z, double spacing_m = 1.0) {
  JunctionSurface surface;
  surface.boundary = {{-10.0, -10.0}, {10.0, -10.0}, {10.0, 10.0}, {-10.0, 10.0}};
  surface.x = surface.y = -12.0;
  surface.spacing_m = spacing_m;
  surface.columns = surface.rows = static_cast<int>(24.0 / spacing_m) + 1;
  for (int r = 0; r < surface.rows; ++r)
    for (int c = 0; c < surface.columns; ++c)
      surface.z.push_back(z(surface.x + c * spacing_m, surface.y + r * spacing_m));
  return surface;
}

/// A road of 20 m that ends at (-10, 0) with a crown of 2.5 %, 3 % gradient and 1 % of superelevation.
Road crowned_arm() {
  Road road = make_road(1, {.x = -30.0, .length = 20.0}, 5.0);
  road.elevation.front().b = 0.03;
  road.superelevation = {{.a = 0.01}};
  road.shape = {{0.0, -10.0, -0.25, 0.025, 0.0, 0.0}, {0.0, 0.0, 0.0, -0.025, 0.0, 0.0}};
  road.successor = {LinkKind::junction, 7};
  return road;
}

TEST(JunctionSurface, QuadraticFieldsAreExactWithTheirSlopes) {
  const auto z = [](double x, double y) { return 300.0 + 0.03 * x - 0.02 * y + 0.001 * x * x - 0.002 * x * y; };
  for (const double spacing : {0.5, 1.0, 2.0}) {
    const JunctionSurface surface = field_of(z, spacing);
    for (double x = -9.7; x < 10.0; x += 0.61)
      for (double y = -9.9; y < 10.0; y += 0.73) {
        const JunctionHeight at = evaluate(surface, x, y);
        EXPECT_NEAR(at.z, z(x, y), 1e-10);
        EXPECT_NEAR(at.dz_dx, 0.03 + 0.002 * x - 0.002 * y, 1e-10);
        EXPECT_NEAR(at.dz_dy, -0.02 - 0.002 * x, 1e-10);
      }
  }
}

TEST(JunctionSurface, MeetsACrownedArmInHeightAndSlopeAcrossTheWholeSection) {
  RoadMap map;
  map.roads = {crowned_arm()};
  map.junctions = {
      {.id = 7, .surface = field_of([](double x, double y) { return 5.5 + 0.1 * std::sin(0.3 * x + y); })}};
  join_arms(map);
  const JunctionSurface& surface = *map.junctions.front().surface;
  ASSERT_EQ(surface.arms.size(), 1u);
  const Road& road = map.roads.front();
  for (double t = -3.5; t <= 3.5; t += 0.23) {
    const SurfacePoint end = surface_point(road, road.length, t);
    const JunctionHeight at = evaluate(surface, end.x, end.y);
    EXPECT_NEAR(at.z, end.z, 1e-8) << t;
    EXPECT_NEAR(at.dz_dx, -end.normal[0] / end.normal[2], 1e-6) << t;
    EXPECT_NEAR(at.dz_dy, -end.normal[1] / end.normal[2], 1e-6) << t;
    // One centimetre inside it is still the arm's strip to rounding of the smooth step.
    const JunctionHeight inside = evaluate(surface, end.x + 0.01, end.y);
    EXPECT_NEAR(inside.z, end.z + 0.01 * 0.03, 1e-6) << t;
  }
  EXPECT_NEAR(evaluate(surface, -6.9, 0.3).z, 5.5 + 0.1 * std::sin(0.3 * -6.9 + 0.3), 0.005)
      << "the field's own beyond 3 m";
}

TEST(JunctionSurface, ArmsSideBySideAreEachExactOnTheirEnd) {
  RoadMap map;
  map.roads = {crowned_arm(), crowned_arm()};
  map.roads[1].id = 2;
  map.roads[1].plan.front().y = 7.4;  // 0.4 m between the edges
  map.roads[1].elevation.front().a = 5.2;
  map.junctions = {{.id = 7, .surface = field_of([](double, double) { return 6.0; })}};
  join_arms(map);
  for (const Road& road : map.roads)
    for (double t = -3.4; t < 3.5; t += 0.4) {
      const SurfacePoint end = surface_point(road, road.length, t);
      EXPECT_NEAR(evaluate(*map.junctions.front().surface, end.x, end.y).z, end.z, 1e-6) << road.id << " " << t;
    }
}

/// Two roads of `length_m` one after the other from junction 7, at the origin, to junction 8; the second runs
/// backwards.
RoadMap short_way(double length_m) {
  RoadMap map;
  map.roads = {make_road(1, {.length = length_m}, 5.0),
               make_road(2, {.x = 2.0 * length_m, .hdg = M_PI, .length = length_m}, 5.3),
               make_road(3, {.x = 2.0 * length_m + 20.0, .length = 20.0}, 5.3)};
  map.roads[0].predecessor = {LinkKind::junction, 7}, map.roads[0].successor = {LinkKind::road, 2, ContactPoint::end};
  map.roads[1].predecessor = {LinkKind::junction, 8}, map.roads[1].successor = {LinkKind::road, 1, ContactPoint::end};
  map.roads[2].predecessor = {LinkKind::junction, 8};
  const auto level = field_of([](double, double) { return 5.1; });
  map.junctions = {{.id = 7, .surface = level}, {.id = 8, .surface = level}};
  return map;
}

TEST(JunctionSurface, WaysTooShortForTwoTransitionsAreNoArms) {
  RoadMap map = short_way(1.9);
  const std::vector<ShortWay> ways = short_ways(map);
  ASSERT_EQ(ways.size(), 1u);
  EXPECT_EQ(ways[0].roads, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(ways[0].junctions, (std::array{7, 8}));
  join_arms(map);
  EXPECT_TRUE(map.junctions[0].surface->arms.empty()) << "road 3 is too far away";
  ASSERT_EQ(map.junctions[1].surface->arms.size(), 1u);
  for (double x = 0.0; x < 3.8; x += 0.1) EXPECT_NEAR(evaluate(*map.junctions[0].surface, x, 0.0).z, 5.1, 1e-9) << x;
  EXPECT_TRUE(short_ways(short_way(2.1)).empty());
  map.junctions[1].surface.reset();
  join_arms(map);
  EXPECT_EQ(map.junctions[0].surface->arms.size(), 1u) << "the other junction has no surface that covers the way";
}

TEST(JunctionSurface, WaysOfOneRoadAreFoundOnce) {
  RoadMap map;
  map.roads = {make_road(1, {.length = 1.0}), make_road(2, {.length = 1.0}), make_road(3, {.length = 1.0})};
  map.roads[0].predecessor = {LinkKind::junction, 7}, map.roads[0].successor = {LinkKind::junction, 8};
  map.roads[1].predecessor = {LinkKind::junction, 7};
  map.roads[2].predecessor = map.roads[2].successor = {LinkKind::road, 3, ContactPoint::start};  // a ring of its own
  EXPECT_EQ(short_ways(map).size(), 1u);
}

TEST(JunctionSurface, SlopesAreTheDerivativesAndHaveNoJump) {
  RoadMap map;
  Road flat = crowned_arm();
  flat.shape.clear();  // the ridge of a crown is a kink of its own
  map.roads = {flat};
  map.junctions = {{.id = 7, .surface = field_of([](double x, double y) { return 5.5 + 0.1 * std::sin(x + y); })}};
  join_arms(map);
  const JunctionSurface& surface = *map.junctions.front().surface;
  constexpr double h = 1e-5;
  for (double x = -9.97; x < -4.0; x += 0.17)
    for (double y = -5.0; y < 5.0; y += 0.19) {
      const JunctionHeight at = evaluate(surface, x, y);
      EXPECT_NEAR(at.dz_dx, (evaluate(surface, x + h, y).z - evaluate(surface, x - h, y).z) / (2.0 * h), 1e-5);
      EXPECT_NEAR(at.dz_dy, (evaluate(surface, x, y + h).z - evaluate(surface, x, y - h).z) / (2.0 * h), 1e-5);
    }
}

TEST(JunctionSurface, StartAndEndOfARoadGiveTheSameArm) {
  Road road = crowned_arm();
  Road turned = make_road(2, {.x = -10.0, .hdg = std::numbers::pi, .length = 20.0}, 5.6);
  turned.elevation.front().b = -0.03;
  turned.superelevation = {{.a = -0.01}};
  turned.shape = road.shape;
  const JunctionArm a = junction_arm(road, ContactPoint::end), b = junction_arm(turned, ContactPoint::start);
  ASSERT_EQ(a.places.size(), b.places.size());
  EXPECT_NEAR(a.x, b.x, 1e-9);
  EXPECT_NEAR(a.in_x, b.in_x, 1e-12);
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    EXPECT_NEAR(a.places[i].left_m, b.places[i].left_m, 1e-9);
    EXPECT_NEAR(a.places[i].z, b.places[i].z, 1e-9);
    EXPECT_NEAR(a.places[i].dz_dinwards, b.places[i].dz_dinwards, 1e-9);
  }
}

TEST(JunctionSurface, ContainsByTheEvenOddRule) {
  JunctionSurface l_shape;
  l_shape.boundary = {{0.0, 0.0}, {4.0, 0.0}, {4.0, 1.0}, {1.0, 1.0}, {1.0, 4.0}, {0.0, 4.0}};
  EXPECT_TRUE(contains(l_shape, 0.5, 3.5));
  EXPECT_TRUE(contains(l_shape, 3.5, 0.5));
  EXPECT_FALSE(contains(l_shape, 2.0, 2.0));
  EXPECT_FALSE(contains(l_shape, -0.1, 0.5));
  EXPECT_FALSE(contains(JunctionSurface{}, 0.0, 0.0));
}

TEST(JunctionSurface, OddQuestionsHaveAnAnswer) {
  const JunctionSurface surface = field_of([](double, double) { return 1.0; });
  EXPECT_NEAR(evaluate(surface, 1e9, -1e9).z, 1.0, 1e-9);
  EXPECT_TRUE(std::isfinite(evaluate(surface, INFINITY, 0.0).z));
  EXPECT_FALSE(contains(surface, NAN, 0.0));
  (void)evaluate(surface, NAN, NAN);
  EXPECT_TRUE(std::isnan(evaluate(JunctionSurface{}, 0.0, 0.0).z));
  JunctionSurface one = surface;
  one.columns = one.rows = 1, one.z = {4.0};
  EXPECT_EQ(evaluate(one, 3.0, 3.0).z, 4.0);
}

}  // namespace
}  // namespace roadquery
