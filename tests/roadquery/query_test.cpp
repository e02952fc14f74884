// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"

namespace roadquery {
namespace {

using test::append;
using test::make_road;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

RoadMap one_road(Road road) {
  RoadMap map;
  map.roads = {std::move(road)};
  return map;
}

TEST(RoadQuery, gives_back_s_and_t_of_surface_points) {
  Road road = make_road(5, {0.0, 458000.0, 5540000.0, 0.6, 60.0, Line{}}, 200.0);
  append(road, 50.0, Spiral{0.0, 0.05});
  append(road, 40.0, Arc{0.05});
  append(road, 50.0, Spiral{0.05, -0.02});
  road.elevation = {{.s = 0.0, .a = 200.0, .b = 0.05, .c = -1e-4}};
  road.superelevation = {{.s = 0.0, .a = 0.0, .b = 4e-4}};
  const RoadQuery query(one_road(road));
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const double s = road.length * (random() / 4294967296.0), t = 3.49 * (random() / 2147483648.0 - 1.0);
    const SurfacePoint p = surface_point(road, s, t);
    Cursor cursor;
    const auto hit = query.find(p.x, p.y, p.z, cursor);
    ASSERT_TRUE(hit) << s << " " << t;
    EXPECT_EQ(hit->road, 0);
    EXPECT_NEAR(hit->s, s, 1e-6);
    EXPECT_NEAR(hit->t, t, 1e-6);
    EXPECT_NEAR(hit->z, p.z, 1e-7);
    EXPECT_EQ(hit->lane_id, t > 0.0 ? 1 : -1);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(hit->normal[static_cast<std::size_t>(k)], p.normal[k], 1e-7);
  }
}

/// A few dozen random roads of all shapes across each other at different heights.
RoadMap random_map(unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
  RoadMap map;
  for (int id = 0; id < 30; ++id) {
    Road road =
        make_road(id, {0.0, uniform(0.0, 400.0), uniform(0.0, 400.0), uniform(-3.2, 3.2), uniform(20.0, 90.0), Line{}},
                  4.0 * id, uniform(1.5, 5.0));
    const double k = uniform(-0.04, 0.04);
    append(road, uniform(20.0, 60.0), Spiral{0.0, k});
    append(road, uniform(5.0, 60.0), Arc{k});
    append(road, 30.0, ParamPoly3{.b_u = 1.0, .c_v = 0.5 * k});
    map.roads.push_back(road);
  }
  return map;
}

/// Nearest of densely sampled points of the reference line, refined by ternary search: no search structure, no Newton.
struct BruteForce {
  bool on_road = false;
  bool uncertain = false;  ///< on an edge, or just beyond an end, where the seam rule decides
  double z = 0.0;
};
BruteForce brute_force(const Road& road, double x, double y) {
  constexpr double step_m = 0.5;
  const auto distance = [&](double s) {
    const PlanPoint p = reference_point(road, s);
    return std::hypot(x - p.x, y - p.y);
  };
  double best = std::numeric_limits<double>::infinity(), best_s = 0.0;
  for (double s = 0.0; s <= road.length; s += step_m) {
    if (const double d = distance(s); d < best) best = d, best_s = s;
  }
  double low = std::max(best_s - step_m, 0.0), high = std::min(best_s + step_m, road.length);
  while (high - low > 1e-7) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    (distance(a) < distance(b) ? high : low) = distance(a) < distance(b) ? b : a;
  }
  const double s = 0.5 * (low + high), off = distance(s), half_width = road_edges(road, s).left_t;  // symmetric roads
  const bool at_end = s < 1e-5 || s > road.length - 1e-5;
  return {off < half_width && !at_end, std::abs(off - half_width) < 1e-4 || (at_end && off < half_width + 1.0),
          elevation(road, s)};
}

TEST(RoadQuery, agrees_with_brute_force_at_random_points) {
  const RoadMap map = random_map(3);
  const RoadQuery query(map);
  std::mt19937 random(4);
  int hits = 0, compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const double x = 500.0 * (random() / 4294967296.0) - 50.0, y = 500.0 * (random() / 4294967296.0) - 50.0;
    const double z_hint = 120.0 * (random() / 4294967296.0);
    bool uncertain = false, any = false;
    double best = std::numeric_limits<double>::infinity(), want_z = 0.0;
    for (const Road& road : map.roads) {
      const double reach = road.length + 10.0;
      if (std::hypot(x - road.plan[0].x, y - road.plan[0].y) > reach) continue;
      const BruteForce b = brute_force(road, x, y);
      uncertain = uncertain || b.uncertain;
      if (b.on_road && std::abs(b.z - z_hint) < best) best = std::abs(b.z - z_hint), want_z = b.z, any = true;
    }
    if (uncertain) continue;
    ++compared;
    Cursor cursor;
    const auto hit = query.find(x, y, z_hint, cursor);
    ASSERT_EQ(hit.has_value(), any) << "at " << x << ", " << y;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->z, want_z, 1e-9) << "at " << x << ", " << y << " hint " << z_hint;
  }
  EXPECT_GT(compared, 2800);
  EXPECT_GT(hits, 250);
}

TEST(RoadQuery, bridge_over_road_is_told_apart_by_height) {
  RoadMap map;
  map.roads = {make_road(1, {0.0, -50.0, 0.0, 0.0, 100.0, Line{}}, 10.0),
               make_road(2, {0.0, 0.0, -50.0, 0.5 * std::numbers::pi, 100.0, Line{}}, 16.0)};
  const RoadQuery query(map);
  for (const auto& [hint, road] :
       {std::pair{10.2, 0}, std::pair{12.9, 0}, std::pair{13.1, 1}, std::pair{30.0, 1}, std::pair{nan, 1}}) {
    Cursor cursor;
    const auto hit = query.find(0.5, 0.5, hint, cursor);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->road, road) << hint;
  }
  // A car that comes along the lower road stays there below the bridge, and one on the bridge stays above.
  Cursor low, high;
  double z_low = 10.0, z_high = 16.0;
  for (double u = -40.0; u <= 40.0; u += 0.02) {
    z_low = query.find(u, 1.0, z_low, low).value().z;
    z_high = query.find(1.0, u, z_high, high).value().z;
    ASSERT_EQ(low.road, 0);
    ASSERT_EQ(high.road, 1);
  }
  EXPECT_EQ(z_low, 10.0);
  EXPECT_EQ(z_high, 16.0);
  // A cursor left on the lower road does not hold a point that has been lifted onto the bridge.
  EXPECT_EQ(query.find(0.0, 0.0, 16.0, low).value().road, 1);
}

TEST(RoadQuery, follows_a_point_across_roads_and_around_a_closed_one) {
  const double radius_m = 50.0;
  const Road ring = make_road(
      1, {0.0, radius_m, 0.0, 0.5 * std::numbers::pi, 2 * std::numbers::pi * radius_m, Arc{1 / radius_m}}, 3.0);
  const RoadQuery query(one_road(ring));
  Cursor cursor;
  for (int i = 0; i <= 40000; ++i) {
    const double angle = 4.0 * std::numbers::pi * i / 40000.0;  // twice around
    const auto hit = query.find(51.0 * std::cos(angle), 51.0 * std::sin(angle), 3.0, cursor);
    ASSERT_TRUE(hit) << angle;
    ASSERT_NEAR(hit->t, -1.0, 1e-6);
    const double s = std::fmod(angle, 2.0 * std::numbers::pi) * radius_m;
    ASSERT_NEAR(std::remainder(hit->s - s, ring.length), 0.0, 1e-6);
  }
}

TEST(RoadQuery, closes_the_wedge_between_roads_that_meet_at_a_slight_angle) {
  RoadMap map;
  map.roads = {make_road(1, {0.0, -50.0, 0.0, 0.0, 50.0, Line{}}), make_road(2, {0.0, 0.0, 0.0, 0.05, 50.0, Line{}})};
  const RoadQuery query(map);
  Cursor cursor;
  for (double x = -10.0; x <= 10.0; x += 0.001) ASSERT_TRUE(query.find(x, -3.0, 0.0, cursor)) << x;
  EXPECT_FALSE(query.find(-50.3, 0.0, 0.0, cursor));  // but not far beyond an end
  EXPECT_TRUE(query.find(-50.2, 0.0, 0.0, cursor));
}

TEST(RoadQuery, kink_between_elements_has_no_hole) {
  Road road = make_road(1, {0.0, -50.0, 0.0, 0.0, 50.0, Line{}});
  road.plan.push_back({50.0, 0.0, 0.0, 0.05, 50.0, Line{}});
  road.length = 100.0;
  const RoadQuery query(one_road(road));
  Cursor moving;
  for (double x = -1.0; x <= 1.0; x += 0.001) {
    Cursor fresh;
    ASSERT_TRUE(query.find(x, -3.0, 0.0, fresh)) << x;
    ASSERT_TRUE(query.find(x, -3.0, 0.0, moving)) << x;
  }
}

TEST(RoadQuery, overlapping_roads_of_a_junction_keep_the_cursors_road) {
  RoadMap map;
  map.roads = {make_road(1, {0.0, -20.0, 0.0, 0.0, 40.0, Line{}}),
               make_road(2, {0.0, 0.0, -20.0, 0.5 * std::numbers::pi, 40.0, Line{}})};
  const RoadQuery query(map);
  for (int road = 0; road < 2; ++road) {
    Cursor cursor{road, 19.0};
    for (double u = -3.0; u <= 3.0; u += 0.01) {
      const auto hit = road == 0 ? query.find(u, 1.5, 0.0, cursor) : query.find(1.5, u, 0.0, cursor);
      ASSERT_EQ(hit.value().road, road) << u;
    }
  }
  Cursor fresh;
  EXPECT_EQ(query.find(1.0, 2.0, 0.0, fresh).value().road,
            1);  // 1 m from the middle of road 1, 2 m from that of road 0
}

TEST(RoadQuery, overlapping_surfaces_of_one_level_are_blended_without_a_step) {
  // Two roads cross 0.2 m above each other: nobody builds that, but two connecting roads of a junction on a slope do
  // it.
  RoadMap map;
  map.roads = {make_road(1, {0.0, -20.0, 0.0, 0.0, 40.0, Line{}}, 5.0),
               make_road(2, {0.0, 0.0, -20.0, 0.5 * std::numbers::pi, 40.0, Line{}}, 5.2)};
  const RoadQuery query(map);
  for (const double y : {-3.0, 0.0, 2.0}) {
    Cursor cursor;
    double z = 5.0;
    for (double x = -15.0; x <= 15.0; x += 0.01) {
      const double next = query.find(x, y, z, cursor).value().z;
      // Steepest where one weight begins and the other is 0.5 m: 0.2 m / 0.5 m.
      ASSERT_NEAR(next, z, 0.01 * 0.2 / 0.5) << x << " " << y;
      z = next;
      if (std::abs(x) > 3.51) {
        ASSERT_NEAR(z, 5.0, 1e-12) << x;
      }
      Cursor fresh;  // where a point came from does not change the height
      ASSERT_EQ(query.find(x, y, z, fresh).value().z, next);
    }
    EXPECT_EQ(cursor.road, 0);
  }
  Cursor cursor;
  EXPECT_NEAR(query.find(0.0, 0.0, 5.0, cursor).value().z, 5.1, 1e-12);  // as deep in one as in the other
}

TEST(RoadQuery, empty_map_far_points_and_strange_numbers) {
  const RoadQuery nothing{RoadMap{}};
  Cursor cursor;
  EXPECT_FALSE(nothing.find(0.0, 0.0, 0.0, cursor));
  const RoadQuery query(one_road(make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}})));
  for (const double v : {nan, std::numeric_limits<double>::infinity(), 1e300, -1e300}) {
    EXPECT_FALSE(query.find(v, 0.0, 0.0, cursor));
    EXPECT_FALSE(query.find(0.0, v, 0.0, cursor));
    cursor = {0, 50.0};
    EXPECT_FALSE(query.find(v, 0.0, 0.0, cursor));
  }
  cursor = {99, -1e300};  // a cursor of another map
  EXPECT_TRUE(query.find(50.0, 1.0, 0.0, cursor));
  Road none = make_road(1, {0.0, 0.0, 0.0, 0.0, 0.0, Line{}});  // no length
  EXPECT_NO_THROW(RoadQuery{one_road(none)});
}

}  // namespace
}  // namespace roadquery
