// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_level.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "scene_site.hpp"

namespace orthodrive::scene {
namespace {

using scene_test::make_road;
using scene_test::RoadShape;
using scene_test::south_m;
using scene_test::west_m;

/// From the corner of the tile; the area is 400 m a side.
Vec2 level_at(double x, double y) { return {west_m + x, south_m + y}; }
const Polygon area = {scene_test::square(west_m, south_m, 400.0), {}};

RoadLevel level_of(const std::vector<roadquery::Road>& roads) {
  std::vector<const roadquery::Road*> pointers;
  for (const roadquery::Road& road : roads) pointers.push_back(&road);
  return RoadLevel(pointers, area, {});
}

double surface_m2(const RoadLevel& level) {
  double sum = 0.0;
  for (const Polygon& polygon : level.polygons()) sum += area_m2(polygon);
  return sum;
}

TEST(RoadLevel, without_roads_there_is_no_surface) {
  const RoadLevel level = level_of({});
  EXPECT_TRUE(level.polygons().empty());
  EXPECT_FALSE(level.sample(level_at(10, 10)));
  EXPECT_FALSE(level.outline().contains(level_at(10, 10)));
}

TEST(RoadLevel, one_road_is_sampled_as_roadquery_has_it) {
  const std::vector<roadquery::Road> roads = {make_road(1, {.start = level_at(50, 50),
                                                            .heading_rad = 0.3,
                                                            .gradient = 0.05,
                                                            .curvature_1pm = 0.01,
                                                            .superelevation_rad = 0.04})};
  const RoadLevel level = level_of(roads);
  EXPECT_NEAR(surface_m2(level), 600.0, 1.0);
  for (const double s : {0.5, 20.0, 99.5})
    for (const double t : {-2.9, 0.0, 1.5}) {
      const auto truth = roadquery::surface_point(roads[0], s, t);
      const auto sample = level.sample({truth.x, truth.y});
      ASSERT_TRUE(sample) << s << ' ' << t;
      EXPECT_NEAR(sample->z_m, truth.z, 1e-6) << s << ' ' << t;
      EXPECT_NEAR(sample->normal.x, truth.normal[0], 1e-6);
      EXPECT_NEAR(sample->normal.z, truth.normal[2], 1e-6);
      EXPECT_NEAR(sample->inside_m, std::min({3.0 - std::abs(t), s, 100.0 - s}), 2e-3) << s << ' ' << t;
    }
}

TEST(RoadLevel, beside_a_road_its_edge_goes_on_for_a_metre) {
  const std::vector<roadquery::Road> roads = {make_road(1, {.start = level_at(50, 50), .superelevation_rad = 0.1})};
  const RoadLevel level = level_of(roads);
  const double edge_m = 3.0 * std::cos(0.1);  // in plan: the road is tilted
  const auto beside = level.sample(level_at(100, 50 + edge_m + 0.5));
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->z_m, 10.0 + 3.0 * std::sin(0.1), 1e-6);
  EXPECT_LT(beside->inside_m, 0.0);
  EXPECT_FALSE(level.sample(level_at(100, 50 + edge_m + 1.1)));
  EXPECT_FALSE(level.sample(level_at(48.5, 50)));
}

TEST(RoadLevel, where_roads_cross_their_heights_are_mixed_without_a_step) {
  const std::vector<roadquery::Road> roads = {
      make_road(1, {.start = level_at(50, 100), .z_m = 10.0}),
      make_road(2, {.start = level_at(100, 50), .heading_rad = 0.5 * M_PI, .z_m = 10.2})};
  const RoadLevel level = level_of(roads);
  EXPECT_EQ(level.polygons().size(), 1U);
  EXPECT_NEAR(surface_m2(level), 2 * 600.0 - 36.0, 0.1);
  EXPECT_NEAR(level.sample(level_at(100, 100))->z_m, 10.1, 1e-9);  // as deep in one as in the other
  double before = level.sample(level_at(90, 100))->z_m, steepest = 0.0;
  EXPECT_NEAR(before, 10.0, 1e-9);
  for (double x = 90.01; x < 110.0; x += 0.01) {
    const double z = level.sample(level_at(x, 100))->z_m;
    steepest = std::max(steepest, std::abs(z - before)), before = z;
  }
  EXPECT_LT(steepest, 0.002);  // 0.2 m over 3 m is 0.0007 m a step; a jump would be 0.1 m
}

TEST(RoadLevel, ends_at_the_area) {
  const std::vector<roadquery::Road> roads = {make_road(1, {.start = level_at(350, 200)})};
  const RoadLevel level = level_of(roads);
  EXPECT_NEAR(surface_m2(level), 300.0, 0.1);
  EXPECT_FALSE(level.outline().contains(level_at(401, 200)));
  EXPECT_TRUE(level.sample(level_at(410, 200)));  // the road goes on
}

TEST(RoadLevel, slivers_between_roads_are_closed_and_real_islands_stay) {
  std::vector<roadquery::Road> roads = {
      make_road(1, {.start = level_at(50, 100)}), make_road(2, {.start = level_at(50, 106.1)}),
      make_road(3, {.start = level_at(60, 90), .heading_rad = 0.5 * M_PI, .length_m = 30}),
      make_road(4, {.start = level_at(140, 90), .heading_rad = 0.5 * M_PI, .length_m = 30})};
  EXPECT_TRUE(level_of(roads).polygons()[0].holes.empty());  // 0.1 m wide
  roads[1] = make_road(2, {.start = level_at(50, 107)});
  ASSERT_EQ(level_of(roads).polygons()[0].holes.size(), 1U);
}

}  // namespace
}  // namespace orthodrive::scene
