// SPDX-License-Identifier: Apache-2.0
// The cross section of a banked road on a slope: turned about the tangent that has the slope, not sheared along z.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace roadquery {
namespace {

using test::append;
using test::make_lane;
using test::make_road;
using Vector = std::array<double, 3>;

Vector of(const SurfacePoint& p) { return {p.x, p.y, p.z}; }
Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vector& a) { return std::sqrt(dot(a, a)); }

/// Rz(heading) Ry(-pitch) Rx(roll) v.
Vector turned(double heading, double pitch, double roll, const Vector& v) {
  const Vector a = {v[0], std::cos(roll) * v[1] - std::sin(roll) * v[2], std::sin(roll) * v[1] + std::cos(roll) * v[2]};
  const Vector b = {std::cos(pitch) * a[0] - std::sin(pitch) * a[2], a[1],
                    std::sin(pitch) * a[0] + std::cos(pitch) * a[2]};
  return {std::cos(heading) * b[0] - std::sin(heading) * b[1], std::sin(heading) * b[0] + std::cos(heading) * b[1],
          b[2]};
}

/// The point (s, t) by the rotation matrix.
Vector by_matrix(const Road& road, double s, double t) {
  const PlanPoint line = reference_point(road, s);
  const Vector off =
      turned(line.hdg, std::atan(gradient(road, s)), superelevation(road, s), {0.0, t, shape(road, s, t).h});
  return {line.x + off[0], line.y + off[1], elevation(road, s) + off[2]};
}

RoadMap alone(Road road) {
  RoadMap map;
  map.roads = {std::move(road)};
  return map;
}

/// Straight, 12 % up, 0.12 rad of superelevation: a plane.
Road plane_road(double heading = 0.7) {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, heading, 100.0, Line{}}, 0.0, 12.0);
  road.elevation = {{0.0, 200.0, 0.12, 0.0, 0.0}};
  road.superelevation = {{0.0, 0.12, 0.0, 0.0, 0.0}};
  return road;
}

/// An arc with a constant slope and superelevation.
Road helix_road() {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.4, 60.0, Arc{0.02}}, 0.0, 6.0);
  road.elevation = {{0.0, 200.0, -0.09, 0.0, 0.0}};
  road.superelevation = {{0.0, 0.07, 0.0, 0.0, 0.0}};
  return road;
}

/// All that changes: slope, superelevation, curvature, crown.
Road winding_road() {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 2.4, 40.0, Line{}}, 0.0, 5.0);
  append(road, 40.0, Spiral{0.0, -0.03});
  append(road, 30.0, Arc{-0.03});
  append(road, 40.0, Spiral{-0.03, 0.04});
  road.elevation = {{0.0, 200.0, 0.1, -1e-3, 1e-6}};
  road.superelevation = {{0.0, -0.06, 2e-3, -1e-5, 0.0}};
  road.shape = {{0.0, -20.0, -0.6, 0.03, 0.0, 0.0},
                {0.0, 0.0, 0.0, -0.03, 0.0, 0.0},
                {150.0, -20.0, -0.4, 0.02, 0.0, 0.0},
                {150.0, 0.0, 0.0, -0.02, 0.0, 0.0}};
  return road;
}

/// As steep as no street: points lie up to 5 m ahead of their cross section.
Road steep_road() {
  Road road = make_road(1, {0.0, 0.0, 0.0, -0.3, 60.0, Line{}}, 0.0, 12.0);
  append(road, 60.0, Arc{0.01});
  road.elevation = {{0.0, 10.0, 0.6, 0.0, 0.0}};
  road.superelevation = {{0.0, 0.8, 0.0, 0.0, 0.0}};
  return road;
}

TEST(TurnedSection, straight_with_slope_and_superelevation_is_a_plane) {
  const Road road = plane_road();
  const double pitch = std::atan(0.12);
  const Vector up = turned(0.7, pitch, 0.12, {0.0, 0.0, 1.0}), across = turned(0.7, pitch, 0.12, {0.0, 1.0, 0.0});
  const Vector origin = of(surface_point(road, 0.0, 0.0));
  for (const double s : {0.0, 31.0, 100.0}) {
    for (const double t : {-12.0, -3.0, 0.0, 0.5, 12.0}) {
      const SurfacePoint p = surface_point(road, s, t);
      EXPECT_NEAR(dot(minus(of(p), origin), up), 0.0, 1e-9) << s << ' ' << t;
      const Vector from_line = minus(of(p), of(surface_point(road, s, 0.0)));
      EXPECT_NEAR(length(from_line), std::abs(t), 1e-9) << "t is true length";
      EXPECT_NEAR(dot(from_line, across), t, 1e-9);
      EXPECT_NEAR(dot(from_line, turned(0.7, pitch, 0.12, {1.0, 0.0, 0.0})), 0.0, 1e-9) << "at right angles";
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(p.normal[k], up[k], 1e-12);
      EXPECT_NEAR(surface_height(road, s, t), p.z, 1e-12);
    }
  }
}

TEST(TurnedSection, every_point_is_the_rotation_matrix_times_t_and_h) {
  for (const Road& road : {plane_road(2.0), helix_road(), winding_road(), steep_road()})
    for (double s = 0.0; s <= road.length; s += 7.3)
      for (const double t : {-4.9, -1.0, 0.0, 2.0, 4.9})
        EXPECT_LT(length(minus(of(surface_point(road, s, t)), by_matrix(road, s, t))), 1e-9) << s << ' ' << t;
}

/// The map of libOpenDRIVE's and esmini's answers: x = 50 + 12 sin(b) sin(p), z = 6 - 12 sin(b) cos(p).
TEST(TurnedSection, file_with_both_has_the_numbers_of_the_rotation) {
  const auto path = std::filesystem::temp_directory_path() / "orthodrive_turned_section.xodr";
  std::ofstream(path) << R"(<OpenDRIVE><header revMajor="1" revMinor="7"/><road id="1" length="100" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<elevationProfile><elevation s="0" a="0" b="0.12" c="0" d="0"/></elevationProfile>
<lateralProfile><superelevation s="0" a="0.12" b="0" c="0" d="0"/></lateralProfile>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right>
<lane id="-1" type="driving"><width sOffset="0" a="12" b="0" c="0" d="0"/></lane>
<lane id="-2" type="sidewalk" level="true"><width sOffset="0" a="2" b="0" c="0" d="0"/></lane>
</right></laneSection></lanes></road></OpenDRIVE>)";
  const RoadQuery query(read_opendrive(path.string()));
  std::filesystem::remove(path);
  const SurfacePoint p = surface_point(query.map().roads[0], 50.0, -12.0);
  EXPECT_NEAR(p.x, 50.1711576, 1e-6);
  EXPECT_NEAR(p.y, -11.9137036, 1e-6);
  EXPECT_NEAR(p.z, 4.5736863, 1e-6);
  Cursor cursor;
  const auto hit = query.find(p.x, p.y + 1e-9, p.z, cursor);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->s, 50.0, 1e-6);
  EXPECT_NEAR(hit->t, -12.0, 1e-6);
  EXPECT_NEAR(hit->z, p.z, 1e-6);

  // The level lane goes on from there, at one height across the road in plan.
  for (const double beside_m : {0.01, 0.7, 1.9}) {
    const auto beside = query.find(p.x, p.y - beside_m, p.z, cursor);
    ASSERT_TRUE(beside);
    EXPECT_EQ(beside->lane_id, -2);
    EXPECT_NEAR(beside->z, p.z, 2e-4) << beside_m;
    EXPECT_NEAR(beside->normal[1], 0.0, 2e-4) << beside_m;
  }
}

TEST(TurnedSection, position_over_is_the_inverse) {
  for (const Road& road : {plane_road(), helix_road(), winding_road(), steep_road()}) {
    for (double s = 0.0; s <= road.length; s += 3.1) {
      for (const double t : {-4.9, -0.3, 0.0, 3.0, 4.9}) {
        const SurfacePoint p = surface_point(road, s, t);
        for (const double near : {s, std::min(s + 6.0, road.length), std::max(s - 6.0, 0.0)}) {
          const RoadPosition at = position_over(road, p.x, p.y, near);
          EXPECT_NEAR(at.s, s, 1e-8) << t;
          EXPECT_NEAR(at.t, t, 1e-8) << s;
          EXPECT_NEAR(at.beyond_m, 0.0, 1e-8);
        }
      }
    }
    const PlanPoint end = reference_point(road, road.length);
    const RoadPosition beyond =
        position_over(road, end.x + 0.5 * std::cos(end.hdg), end.y + 0.5 * std::sin(end.hdg), road.length - 3.0);
    EXPECT_EQ(beyond.s, road.length);
    EXPECT_NEAR(beyond.beyond_m, 0.5, 1e-9);
  }
}

TEST(TurnedSection, query_finds_every_point_again) {
  for (const Road& built : {plane_road(), helix_road(), winding_road(), steep_road()}) {
    const RoadQuery query(alone(built));
    const Road& road = query.map().roads[0];
    Cursor driving;
    for (double s = 0.013; s < road.length; s += 0.171) {
      for (const double t : {-4.9, -0.3, 0.1, 3.0, 4.9}) {  // a crown bends at 0
        const SurfacePoint p = surface_point(road, s, t);
        Cursor fresh, elsewhere{0, road.length - s};
        for (Cursor* cursor : {&fresh, &driving, &elsewhere}) {
          const auto hit = query.find(p.x, p.y, p.z, *cursor);
          ASSERT_TRUE(hit) << s << ' ' << t;
          EXPECT_NEAR(hit->s, s, 3e-6) << t;
          EXPECT_NEAR(hit->t, t, 1e-6) << s;
          EXPECT_NEAR(hit->z, p.z, 1e-6) << s << ' ' << t;
          for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(hit->normal[k], p.normal[k], 2e-6) << s << ' ' << t;
        }
        const auto there = query.at(0, s, t);
        ASSERT_TRUE(there);
        EXPECT_NEAR(there->z, p.z, 1e-6);
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(there->normal[k], p.normal[k], 2e-6);
      }
      const Edges edges = road_edges(road, s);
      const auto section = query.section(0, s);
      ASSERT_TRUE(section);
      EXPECT_LT(length(minus(section->left, of(surface_point(road, s, edges.left_t)))), 3e-6);
      EXPECT_LT(length(minus(section->right, of(surface_point(road, s, edges.right_t)))), 3e-6);
    }
  }
}

TEST(TurnedSection, normals_are_those_of_the_heights_in_plan) {
  constexpr double h = 1e-3;
  Road kerb = winding_road();
  kerb.sections[0].right.push_back(make_lane(-2, 2.0));
  kerb.sections[0].right.back().heights = {{10.0, 0.1, 0.12}, {90.0, 0.15, 0.05}};
  for (const Road& built : {plane_road(), helix_road(), winding_road(), steep_road(), kerb}) {
    const RoadQuery query(alone(built));
    const Road& road = query.map().roads[0];
    const auto z = [&](double x, double y, double z_hint) {
      Cursor cursor;
      return query.find_height(x, y, z_hint, cursor).value();
    };
    for (double s = 12.2; s < road.length - 12.0; s += 5.7) {
      for (const double t : {-6.1, -4.0, 0.7, 4.0}) {
        if (t < road_edges(road, s).right_t) continue;
        const SurfacePoint p = surface_point(road, s, t);
        const double dz_dx = (z(p.x + h, p.y, p.z) - z(p.x - h, p.y, p.z)) / (2.0 * h),
                     dz_dy = (z(p.x, p.y + h, p.z) - z(p.x, p.y - h, p.z)) / (2.0 * h);
        Cursor cursor;
        const auto hit = query.find(p.x, p.y, p.z, cursor);
        ASSERT_TRUE(hit);
        EXPECT_NEAR(-hit->normal[0] / hit->normal[2], dz_dx, 1e-4) << s << ' ' << t;
        EXPECT_NEAR(-hit->normal[1] / hit->normal[2], dz_dy, 1e-4) << s << ' ' << t;
        EXPECT_NEAR(-p.normal[0] / p.normal[2], dz_dx, 1e-4) << s << ' ' << t;
        EXPECT_NEAR(-p.normal[1] / p.normal[2], dz_dy, 1e-4) << s << ' ' << t;
      }
    }
  }
}

TEST(TurnedSection, curvature_of_a_helix_is_one_over_its_distance_from_the_axis) {
  Road steep = helix_road();
  steep.elevation[0].b = 0.4, steep.superelevation[0].a = 0.5;
  const RoadQuery query(alone(steep));
  const Road& road = query.map().roads[0];
  const PlanPoint start = reference_point(road, 0.0);
  const double axis_x = start.x - 50.0 * std::sin(start.hdg), axis_y = start.y + 50.0 * std::cos(start.hdg);
  for (const double t : {-5.9, -1.0, 0.0, 5.9}) {
    const SurfacePoint p = surface_point(road, 20.0, t);
    EXPECT_NEAR(query.at(0, 20.0, t)->curvature, 1.0 / std::hypot(p.x - axis_x, p.y - axis_y), 2e-8) << t;
  }
}

TEST(TurnedSection, roads_without_slope_or_without_cross_section_take_the_short_way) {
  const auto turned_stations = [](const Road& road) {
    const RoadQuery query(alone(road));
    std::size_t count = 0;
    for (const Station& station : query.baked().stations) count += station.turned != not_turned ? 1 : 0;
    return count;
  };
  Road level = plane_road(), unbanked = plane_road();
  level.elevation = {{0.0, 200.0, 0.0, 0.0, 0.0}};
  unbanked.superelevation.clear();
  EXPECT_EQ(turned_stations(level), 0u);
  EXPECT_EQ(turned_stations(unbanked), 0u);
  EXPECT_GT(turned_stations(plane_road()), 0u);
}

TEST(TurnedSection, roads_in_line_meet_without_a_gap) {
  for (const Road& whole : {plane_road(), helix_road()}) {
    RoadMap map;
    for (int part = 0; part < 2; ++part) {
      Road road = whole;
      const PlanPoint start = reference_point(whole, part * 0.5 * whole.length);
      road.id = part + 1;
      road.length = road.plan[0].length = 0.5 * whole.length;
      road.plan[0].x = start.x, road.plan[0].y = start.y, road.plan[0].hdg = start.hdg;
      road.elevation[0].a = elevation(whole, part * 0.5 * whole.length);
      map.roads.push_back(road);
    }
    const RoadQuery query(map);
    for (const double t : {-5.9, -2.0, 0.0, 2.0, 5.9}) {
      for (double s = 0.5 * whole.length - 0.4; s < 0.5 * whole.length + 0.4; s += 0.0101) {
        const SurfacePoint p = surface_point(whole, s, t);
        Cursor cursor;
        const auto hit = query.find(p.x, p.y, p.z, cursor);
        ASSERT_TRUE(hit) << s << ' ' << t;
        EXPECT_EQ(hit->road, s < 0.5 * whole.length ? 0 : 1) << s << ' ' << t;
        EXPECT_NEAR(hit->z, p.z, 1e-6) << s << ' ' << t;
        EXPECT_NEAR(hit->s + 0.5 * whole.length * hit->road, s, 3e-6);
      }
    }
  }
}

TEST(TurnedSection, arm_of_a_junction_goes_on_in_the_plane_of_its_road) {
  const Road road = plane_road();
  const Vector up = turned(0.7, std::atan(0.12), 0.12, {0.0, 0.0, 1.0}), origin = of(surface_point(road, 0.0, 0.0));
  for (const ContactPoint end : {ContactPoint::start, ContactPoint::end}) {
    const JunctionArm arm = junction_arm(road, end);
    for (const double in_m : {-1.0, 0.0, 2.0})
      for (const double left_m : {-11.0, -4.0, 0.0, 9.0}) {
        const double x = arm.x + in_m * arm.in_x - left_m * arm.in_y, y = arm.y + in_m * arm.in_y + left_m * arm.in_x;
        const double z = origin[2] - (up[0] * (x - origin[0]) + up[1] * (y - origin[1])) / up[2];
        EXPECT_NEAR(arm_height(arm, in_m, left_m), z, 1e-9) << in_m << ' ' << left_m;
      }
  }
}

}  // namespace
}  // namespace roadquery
