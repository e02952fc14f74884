// SPDX-License-Identifier: Apache-2.0
// What a query answers does not depend on where its cursor was, nor on what else is asked for.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/tables/junction_index.hpp"

namespace roadquery {
namespace {

using test::make_road;

struct Uniform {
  std::mt19937 random;
  double operator()(double low, double high) { return low + (high - low) * (random() / 4294967296.0); }
};

/// Twelve turning roads through the origin, up to 0.4 m apart, in a junction whose own surface is 0.3 m above the
/// plane, steep or not; two decks over them, so near that guesses between count; one road that lies over itself.
RoadMap crowded(bool with_surface, double slope) {
  RoadMap map;
  for (int id = 0; id < 12; ++id) {
    const double hdg = 0.5 * id;
    Road road = make_road(
        id, {0.0, -20.0 * std::cos(hdg), -20.0 * std::sin(hdg), hdg, 40.0, Spiral{0.0, id % 2 == 0 ? 0.02 : -0.03}});
    road.elevation = {{.a = 5.0 + 0.035 * id - slope * 20.0 * std::cos(hdg), .b = slope * std::cos(hdg)}};
    road.superelevation = {{.a = -slope * std::sin(hdg)}};
    road.junction = 7;
    map.roads.push_back(std::move(road));
  }
  map.roads.push_back(make_road(20, {0.0, -40.0, 3.0, 0.0, 80.0, Line{}}, 7.0));
  map.roads.push_back(make_road(21, {0.0, 2.0, -40.0, 0.5 * std::numbers::pi, 80.0, Line{}}, 8.1));
  Road loop = make_road(30, {0.0, 5.0, 9.0, 0.0, 80.0, Arc{0.15}}, 5.2, 2.0);
  loop.elevation.front().b = 0.02;
  map.roads.push_back(std::move(loop));
  if (!with_surface) return map;
  JunctionSurface surface;
  surface.boundary = {{-9.0, -11.0}, {8.0, -12.0}, {12.0, 3.0}, {4.0, 4.0}, {5.0, 12.0}, {-7.0, 9.0}, {-3.0, 0.5}};
  surface.x = surface.y = -14.0;
  surface.columns = surface.rows = 29;
  for (int r = 0; r < surface.rows; ++r)
    for (int c = 0; c < surface.columns; ++c)
      surface.z.push_back(5.3 + slope * (surface.x + c) + 0.05 * std::sin(0.7 * c + r));
  map.junctions = {{.id = 7, .surface = std::move(surface)}};
  return map;
}

TEST(RoadQuery, answer_does_not_depend_on_the_cursor) {
  for (const bool with_surface : {false, true}) {
    for (const double slope : {0.0, 0.12}) {
      const RoadQuery query(crowded(with_surface, slope));
      Uniform uniform{std::mt19937(3)};
      int hits = 0, in_junction = 0;
      for (int run = 0; run < 800; ++run) {
        const double heading = uniform(-3.2, 3.2), x = uniform(-18.0, 18.0), y = uniform(-18.0, 18.0);
        const double guess = uniform(3.5, 9.5);
        Cursor moving;
        for (int i = 0; i < 60; ++i) {
          const double px = x + 0.1 * i * std::cos(heading), py = y + 0.1 * i * std::sin(heading);
          const double z_hint = guess + slope * px;
          Cursor fresh, for_height = moving;
          const auto a = query.find(px, py, z_hint, moving), b = query.find(px, py, z_hint, fresh);
          const auto z = query.find_height(px, py, z_hint, for_height);
          ASSERT_EQ(a.has_value(), b.has_value()) << px << " " << py << " " << z_hint;
          ASSERT_EQ(a.has_value(), z.has_value());
          if (!a) continue;
          ++hits, in_junction += a->in_junction ? 1 : 0;
          ASSERT_NEAR(a->z, b->z, 1e-9) << px << " " << py << " " << z_hint;
          ASSERT_EQ(a->in_junction, b->in_junction) << px << " " << py << " " << z_hint;
          ASSERT_EQ(a->z, *z);
          ASSERT_EQ(moving.station, for_height.station);
          for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(a->normal[k], b->normal[k], 1e-9);
        }
      }
      EXPECT_GT(hits, 20000);
      EXPECT_EQ(in_junction > 5000, with_surface) << in_junction;
    }
  }
}

TEST(RoadQuery, parts_of_a_hit_are_those_of_the_whole) {
  const RoadQuery query(crowded(true, 0.05));
  Uniform uniform{std::mt19937(4)};
  for (int i = 0; i < 3000; ++i) {
    const double x = uniform(-25.0, 25.0), y = uniform(-25.0, 25.0), guess = uniform(4.0, 9.0);
    Cursor one, other;
    const auto all = query.find(x, y, guess, one);
    for (const unsigned parts : {0U, 1U, 2U, 4U, 8U, 9U}) {
      other = {};
      const auto hit = query.find(x, y, guess, other, parts);
      ASSERT_EQ(hit.has_value(), all.has_value());
      if (!hit) continue;
      EXPECT_EQ(hit->z, all->z);
      EXPECT_EQ(hit->road, all->road);
      EXPECT_EQ(hit->in_junction, all->in_junction);
      if ((parts & hit_normal) != 0) {
        EXPECT_EQ(hit->normal, all->normal);
      }
      if ((parts & hit_position) != 0) {
        EXPECT_EQ(hit->lane_id, all->lane_id);
        EXPECT_EQ(hit->s, all->s);
        EXPECT_EQ(hit->t, all->t);
      }
      if ((parts & hit_curvature) != 0) {
        EXPECT_EQ(hit->curvature, all->curvature);
      }
      if ((parts & hit_material) != 0) {
        EXPECT_EQ(hit->friction, all->friction);
      }
    }
  }
}

TEST(JunctionIndex, contains_is_that_of_the_whole_ring) {
  Uniform uniform{std::mt19937(5)};
  for (const int corners : {3, 4, 7, 60, 900}) {
    RoadMap map;
    JunctionSurface surface;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / corners, radius = uniform(5.0, 30.0);
      surface.boundary.push_back({1000.0 + radius * std::cos(angle), -500.0 + radius * std::sin(angle)});
    }
    if (corners == 4) surface.boundary = {{0.0, 0.0}, {10.0, 0.0}, {10.0, 0.0}, {0.0, 0.0}};  // of no height
    map.junctions = {{.id = 1}, {.id = 2, .surface = surface}};
    const JunctionIndex index(map);
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
      const double x = uniform(965.0, 1035.0), y = uniform(-535.0, -465.0);
      ASSERT_EQ(index.contains(1, x, y), contains(surface, x, y)) << x << " " << y;
      inside += contains(surface, x, y) ? 1 : 0;
    }
    for (const auto& p : surface.boundary) ASSERT_EQ(index.contains(1, p[0], p[1]), contains(surface, p[0], p[1]));
    EXPECT_EQ(inside > 500, corners != 4);
    EXPECT_FALSE(index.contains(0, 1000.0, -500.0)) << "a junction without a surface";
  }
}

TEST(JunctionIndex, over_is_evaluate_inside_the_ring) {
  Uniform uniform{std::mt19937(7)};
  for (const int arms : {0, 1, 3, 300}) {
    JunctionSurface surface;
    surface.x = 970.0, surface.y = -530.0, surface.spacing_m = 0.5, surface.columns = 121, surface.rows = 121;
    for (int i = 0; i < surface.columns * surface.rows; ++i) surface.z.push_back(uniform(199.0, 201.0));
    for (int k = 0; k < 40; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / 40, radius = uniform(12.0, 34.0);  // also beyond the grid
      surface.boundary.push_back({1000.0 + radius * std::cos(angle), -500.0 + radius * std::sin(angle)});
    }
    for (int k = 0; k < arms; ++k) {
      const double heading = 2.0 * std::numbers::pi * k / arms, away = k % 2 == 0 ? 12.0 : 3.0;
      surface.arms.push_back({1000.0 + away * std::cos(heading),
                              -500.0 + away * std::sin(heading),
                              -std::cos(heading),
                              -std::sin(heading),
                              {{-4.0, 200.5, 0.03}, {0.5, 200.4, 0.02}, {3.0, 200.2, 0.01}}});
    }
    RoadMap map;
    map.junctions = {{.id = 2, .surface = surface}};
    const JunctionIndex index(map);
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
      const double x = uniform(965.0, 1035.0), y = uniform(-535.0, -465.0);
      const JunctionOver over = index.over(0, x, y);
      ASSERT_EQ(over.junction == 0, contains(surface, x, y)) << x << " " << y;
      if (over.junction != 0) continue;
      const JunctionHeight exact = evaluate(surface, x, y);
      ASSERT_NEAR(over.at.z, exact.z, 1e-10) << arms << " arms, " << x << " " << y;
      ASSERT_NEAR(over.at.dz_dx, exact.dz_dx, 1e-9);
      ASSERT_NEAR(over.at.dz_dy, exact.dz_dy, 1e-9);
      ++inside;
    }
    EXPECT_GT(inside, 2000);
  }
}

/// A road of 700 m of width and its turn: cells that lie hundreds of metres beside their stations.
TEST(RoadQuery, very_wide_road_is_found_everywhere) {
  RoadMap map;
  map.roads = {make_road(1, {0.0, 0.0, 0.0, 0.4, 300.0, Arc{0.001}}, 2.0, 480.0)};
  const RoadQuery query(map);
  Uniform uniform{std::mt19937(6)};
  for (int i = 0; i < 2000; ++i) {
    const double s = uniform(0.1, 299.9), t = uniform(-479.9, 479.9);
    const SurfacePoint p = surface_point(map.roads[0], s, t);
    Cursor cursor;
    const auto hit = query.find(p.x, p.y, p.z, cursor);
    ASSERT_TRUE(hit) << s << " " << t;
    EXPECT_NEAR(hit->s, s, 1e-4);
    EXPECT_NEAR(hit->t, t, 1e-4);
  }
}

TEST(RoadQuery, section_is_the_exact_surface_at_edges_and_line) {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.6, 40.0, Line{}}, 200.0);
  test::append(road, 40.0, Spiral{0.0, 0.05});
  test::append(road, 20.0, ParamPoly3{.b_u = 1.0, .c_u = -1e-4, .c_v = 0.01, .d_v = -2e-4});
  road.elevation = {{0.0, 200.0, 0.05, -1e-3, 0.0}, {60.0, 200.3, -0.03, 0.0, 0.0}};
  road.superelevation = {{0.0, 0.02, 1e-3, 0.0, 0.0}};
  road.shape = {{20.0, -30.0, -0.6, 0.02, 0.0, 0.0}, {20.0, 0.0, 0.0, -0.02, 0.0, 0.0}};  // begins with a step
  LaneSection later = road.sections[0];
  later.s = 30.0;
  later.right.push_back(test::make_lane(-2, 2.5));
  road.sections.push_back(later);
  RoadMap map;
  map.roads = {road};
  const RoadQuery query(map);
  for (double s = 0.0; s <= road.length; s += 0.125) {
    for (const double at : {s, s - 1e-4}) {
      const auto section = query.section(0, at);
      ASSERT_TRUE(section);
      const Edges edges = road_edges(road, at);
      const auto expect = [&](const std::array<double, 3>& got, double t) {
        const SurfacePoint want = surface_point(road, at, t);
        EXPECT_NEAR(std::hypot(got[0] - want.x, got[1] - want.y, got[2] - want.z), 0.0, 2e-6) << at << " " << t;
      };
      expect(section->left, edges.left_t), expect(section->right, edges.right_t), expect(section->reference, 0.0);
    }
  }
  EXPECT_FALSE(query.section(1, 0.0));
  EXPECT_FALSE(query.section(0, NAN));
}

}  // namespace
}  // namespace roadquery
