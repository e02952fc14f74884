// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <random>

#include "paths.hpp"
#include "roadquery/count_allocations.hpp"
#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/blend.hpp"

namespace roadquery {
namespace {

using test::append;
using test::make_lane;
using test::make_road;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();

/// Every shape of line, some of them tight; cubics everywhere, a crown that changes, a lane that begins and one that
/// widens.
Road everything() {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.6, 30.0, Line{}}, 200.0);
  append(road, 25.0, Spiral{0.0, 0.08});
  append(road, 10.0, Arc{0.08});
  append(road, 25.0, Spiral{0.08, -0.15});
  append(road, 6.0, Arc{-0.15});
  append(road, 30.0, ParamPoly3{.b_u = 1.0, .c_u = -1e-4, .c_v = 0.01, .d_v = -2e-4});
  append(road, 30.0, ParamPoly3{.b_u = 30.3, .c_u = -0.4, .c_v = 4.0, .d_v = -2.0, .normalized = true});
  road.elevation = {{0.0, 200.0, 0.05, -1e-3, 2e-6}, {60.0, 200.3, -0.03, 1e-3, -4e-6}};
  road.superelevation = {{0.0, 0.02, 1e-3, -1e-5, 0.0}, {80.0, 0.05, -1e-3, 0.0, 1e-7}};
  road.shape = {{20.0, -30.0, -0.6, 0.02, 0.0, 0.0},  {20.0, 0.0, 0.0, -0.02, 0.0, 0.0},
                {50.0, -30.0, -0.9, 0.03, 0.0, 0.0},  {50.0, 0.0, 0.0, -0.03, 0.0, 0.0},
                {90.0, -3.5, -0.1, 0.02, 0.003, 0.0}, {90.0, 1.0, 0.05, -0.01, 0.0, 1e-3},
                {120.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
  road.lane_offset = {{0.0, 0.0, 0.0, 0.0, 0.0}, {100.0, 0.0, 0.01, 0.0, 0.0}};
  LaneSection later = road.sections[0];
  later.s = 70.0;
  later.right.push_back(make_lane(-2, 0.0));
  later.right.back().width = {{0.0, 0.0, 0.0, 0.01, -2e-4}, {20.0, 2.4, 0.0, 0.0, 0.0}};
  later.left[0].materials = {{0.0, SurfaceClass::concrete, 0.9, 0.001}, {40.0, SurfaceClass::setts, 0.7, 0.004}};
  road.sections.push_back(later);
  return road;
}

RoadMap map_of_road(Road road) {
  RoadMap map;
  map.roads = {std::move(road)};
  return map;
}

TEST(BakedRoad, is_the_exact_surface_within_a_tenth_of_a_millimetre) {
  const RoadQuery query(map_of_road(everything()));
  const Road& road = query.map().roads[0];
  for (const Station& q : query.baked().stations) {
    for (const double part : {-0.999, -0.7, -0.3, 0.1, 0.5, 0.999}) {
      const double s = q.s + part * q.half_m;
      const Edges edges = road_edges(road, s);
      for (const double share : {0.001, 0.3, 0.6, 0.999}) {
        const double t = edges.right_t + share * (edges.left_t - edges.right_t);
        const SurfacePoint exact = surface_point(road, s, t);
        const auto baked = query.at(0, s, t);
        ASSERT_TRUE(baked) << s;
        EXPECT_NEAR(baked->z, exact.z, 1e-6) << s << ' ' << t;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(baked->normal[static_cast<std::size_t>(k)], exact.normal[k], 1e-5) << s;
        const PlanPoint line = reference_point(road, s);
        const double left = (exact.y - line.y) * std::cos(line.hdg) - (exact.x - line.x) * std::sin(line.hdg);
        if (1.0 - line.curvature * left < 0.3) continue;  // s and t are hardly one to one there
        Cursor cursor{0, s};
        const auto hit = query.find(exact.x, exact.y, exact.z, cursor);
        ASSERT_TRUE(hit) << s << ' ' << t;
        EXPECT_NEAR(hit->s, s, 2e-5) << t;
        EXPECT_NEAR(hit->t, t, 1e-5) << s;
        EXPECT_NEAR(hit->z, exact.z, 1e-5) << s << ' ' << t;
        const double curvature = line.curvature / (1.0 - line.curvature * left);
        EXPECT_NEAR(hit->curvature, curvature, 1e-3 + 1e-3 * std::abs(curvature)) << s << ' ' << t;
      }
    }
  }
}

TEST(BakedRoad, shapes_that_begin_under_a_point_on_a_banked_road_are_the_exact_ones) {
  // The shape moves points sideways by h sin(bank), 3 cm: the foot crosses from one piece to the next.
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.6, 60.0, Line{}}, 200.0);
  road.superelevation = {{0.0, 0.2, 0.0, 0.0, 0.0}};
  for (const double s : {0.0, 60.0})
    road.shape.insert(
        road.shape.end(),
        {{s, -2.0, 0.15, -0.02, 0.0, 0.0}, {s, 1.0, 0.09, 0.1, 0.02, 0.0}, {s, 1.5, 0.145, -0.2, 0.0, 0.0}});
  const RoadQuery query(map_of_road(road));
  for (double t = 0.9; t < 1.6; t += 1e-3) {
    const SurfacePoint exact = surface_point(road, 31.0, t);
    Cursor cursor{0, 31.0};
    const auto hit = query.find(exact.x, exact.y, exact.z, cursor);
    ASSERT_TRUE(hit) << t;
    EXPECT_NEAR(hit->t, t, 1e-6);
    EXPECT_NEAR(hit->z, exact.z, 1e-6) << t;
  }
}

TEST(BakedRoad, lanes_are_those_of_the_road_with_their_material) {
  const RoadQuery query(map_of_road(everything()));
  const auto at = [&](double s, double t) { return query.at(0, s, t).value(); };
  EXPECT_EQ(at(10.0, 1.0).lane_id, 1);
  EXPECT_EQ(at(10.0, -3.0).lane_id, -1);
  EXPECT_EQ(at(95.0, -4.5).lane_id, -2);
  EXPECT_EQ(at(95.0, -6.5).lane_id, 0);
  EXPECT_EQ(at(10.0, 1.0).surface, SurfaceClass::asphalt);
  EXPECT_EQ(at(10.0, 1.0).friction, 1.0);
  EXPECT_EQ(at(100.0, 1.0).surface, SurfaceClass::concrete);
  EXPECT_NEAR(at(100.0, 1.0).friction, 0.9, 1e-6);
  EXPECT_EQ(at(115.0, 1.0).surface, SurfaceClass::setts);
  EXPECT_NEAR(at(115.0, 1.0).roughness_m, 0.004, 1e-8);
  EXPECT_EQ(at(115.0, -1.0).surface, SurfaceClass::asphalt);
}

TEST(RoadQuery, height_alone_is_the_hits_height) {
  RoadMap map = map_of_road(everything());
  map.roads.push_back(make_road(2, {0.0, 458010.0, 5540000.0, 1.2, 60.0, Line{}}, 200.4));
  map.roads[1].id = 2;
  const RoadQuery query(map);
  std::mt19937 random(1);
  Cursor a, b;
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = 458000.0 + 60.0 * (random() / 4294967296.0), y = 5540000.0 + 60.0 * (random() / 4294967296.0);
    const auto hit = query.find(x, y, 200.0, a);
    const auto z = query.find_height(x, y, 200.0, b);
    ASSERT_EQ(hit.has_value(), z.has_value());
    EXPECT_EQ(a.station, b.station);
    if (!hit || !z) continue;
    ++hits;
    EXPECT_EQ(hit->z, *z);
  }
  EXPECT_GT(hits, 1000);
}

TEST(RoadQuery, does_not_allocate) {
  RoadMap map = map_of_road(everything());
  map.roads.push_back(make_road(2, {0.0, 458010.0, 5540000.0, 1.2, 60.0, Line{}}, 200.4));
  const RoadQuery query(map);
  std::mt19937 random(1);
  Cursor cursor;
  const long before = test::allocations();
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = 458000.0 + 60.0 * (random() / 4294967296.0), y = 5540000.0 + 60.0 * (random() / 4294967296.0);
    hits += query.find(x, y, 200.0, cursor).has_value() + query.find_height(x, y, not_a_number, cursor).has_value();
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(hits, 1000);
  ::operator delete(::operator new(1));  // of a new-expression the compiler may leave the call out
  EXPECT_GT(test::allocations(), before) << "allocations are counted";
}

TEST(RoadQuery, numbers_that_are_none_have_defined_answers) {
  const RoadQuery query(map_of_road(make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}, 5.0)));
  for (const double v : {not_a_number, infinity, -infinity, 1e300, 4e9, -4e9}) {
    Cursor cursor{0, 50.0};
    EXPECT_FALSE(query.find(v, 0.0, 5.0, cursor));
    EXPECT_EQ(cursor.road, -1);
    cursor = {0, 50.0};
    EXPECT_FALSE(query.find_height(50.0, v, 5.0, cursor));
    EXPECT_FALSE(query.at(0, 50.0, std::isfinite(v) ? not_a_number : v));
  }
  for (const double guess :
       {not_a_number, infinity, -infinity, 1e300}) {  // the surface there is, however far the guess
    Cursor cursor{0, 50.0};
    const auto hit = query.find(50.0, 1.0, guess, cursor);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->z, 5.0);
  }
  EXPECT_FALSE(query.at(0, not_a_number, 0.0));
  EXPECT_FALSE(query.at(7, 1.0, 0.0));
  const auto end = query.at(0, 1e9, 0.0);
  ASSERT_TRUE(end);
  EXPECT_EQ(end->s, 100.0);
  for (const double s : {not_a_number, infinity, -1e300}) {
    Cursor cursor{0, s};
    EXPECT_TRUE(query.find(50.0, 1.0, 5.0, cursor)) << "a cursor with a broken s";
  }
}

TEST(RoadQuery, guess_half_way_between_two_decks_takes_the_first_road) {
  RoadMap map;
  map.roads = {make_road(1, {0.0, -50.0, 0.0, 0.0, 100.0, Line{}}, 10.0),
               make_road(2, {0.0, 0.0, -50.0, 0.5 * std::numbers::pi, 100.0, Line{}}, 16.0)};
  const RoadQuery query(map);
  Cursor cursor;
  const auto first = query.find(0.5, 0.5, 13.0, cursor);
  ASSERT_TRUE(first);
  for (int i = 0; i < 3; ++i) {
    Cursor again;
    const auto next = query.find(0.5, 0.5, 13.0, again);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->road, first->road);
  }
  EXPECT_EQ(first->road, 0);
}

TEST(RoadQuery, road_that_cannot_be_is_refused) {
  Road turning = make_road(1, {0.0, 0.0, 0.0, 0.0, 1000.0, Arc{1.0}});
  EXPECT_THROW(RoadQuery{map_of_road(turning)}, std::runtime_error);
  EXPECT_THROW(RoadQuery{map_of_road(make_road(1, {0.0, 0.0, 0.0, 0.0, 2e7, Line{}}))}, std::runtime_error);
  EXPECT_THROW(RoadQuery{map_of_road(make_road(1, {0.0, 2e8, 0.0, 0.0, 20.0, Line{}}))}, std::runtime_error);
  EXPECT_THROW(RoadQuery{map_of_road(make_road(1, {0.0, 0.0, 0.0, 0.0, 20.0, Line{}}, 0.0, 2000.0))},
               std::runtime_error);
}

TEST(RoadQuery, mesh_sample_is_what_a_wheel_finds) {
  RoadMap map;  // two that cross 0.3 m apart, a deck over both
  map.roads = {make_road(1, {0.0, -20.0, 0.0, 0.0, 40.0, Line{}}, 5.0),
               make_road(2, {0.0, 0.0, -20.0, 0.5 * std::numbers::pi, 40.0, Line{}}, 5.3),
               make_road(3, {0.0, -20.0, 1.0, 0.0, 40.0, Line{}}, 12.0)};
  const RoadQuery query(map);
  const std::vector<bool> ground = {true, true, false}, deck = {false, false, true};
  std::mt19937 random(5);
  int compared = 0;
  for (int i = 0; i < 5000; ++i) {
    const double x = 30.0 * (random() / 4294967296.0) - 15.0, y = 30.0 * (random() / 4294967296.0) - 15.0;
    for (const auto* level : {&ground, &deck}) {
      const auto mesh = query.sample(x, y, 1.0, *level);
      if (!mesh || mesh->inside_m < 0.0) continue;
      Cursor cursor;
      const auto wheel = query.find(x, y, mesh->z, cursor);
      ASSERT_TRUE(wheel);
      EXPECT_EQ(mesh->z, wheel->z);
      EXPECT_EQ(mesh->normal, wheel->normal);
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000);
}

/// Files of others: the tables against the exact functions, which agreed with libOpenDRIVE to the last
/// digit.
TEST(RoadQuery, heights_of_others_files_are_the_exact_ones) {
  const std::filesystem::path samples = orthodrive::paths::in_source("../shared/data/opendrive/samples");
  if (!std::filesystem::exists(samples)) GTEST_SKIP() << samples << " is missing";
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(samples)) {
    if (entry.path().extension() != ".xodr") continue;
    ++files;
    const RoadQuery query(read_opendrive(entry.path().string()));
    std::mt19937 random(1);
    for (std::size_t r = 0; r < query.map().roads.size(); ++r) {
      const Road& road = query.map().roads[r];
      if (road.sections.empty()) continue;
      for (int i = 0; i < 50; ++i) {
        const double s = road.length * (random() / 4294967296.0);
        const Edges edges = road_edges(road, s);
        const double t = edges.right_t + (edges.left_t - edges.right_t) * (random() / 4294967296.0);
        const auto baked = query.at(r, s, t);
        ASSERT_TRUE(baked) << entry.path() << " road " << road.id;
        EXPECT_NEAR(baked->z, surface_point(road, s, t).z, 1e-4) << entry.path() << " road " << road.id << " s " << s;
      }
    }
  }
  EXPECT_GE(files, 3);
}

}  // namespace
}  // namespace roadquery
