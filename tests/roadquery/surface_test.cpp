// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roadquery/make_road.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

using test::make_lane;
using test::make_road;

TEST(Plan, arc_of_a_quarter_circle_ends_where_geometry_says) {
  const double radius_m = 50.0, quarter_m = 0.5 * std::numbers::pi * radius_m;
  for (const double sign : {1.0, -1.0}) {
    const PlanElement arc{0.0, 10.0, 20.0, 0.0, quarter_m, Arc{sign / radius_m}};
    const PlanPoint end = evaluate(arc, quarter_m);
    EXPECT_NEAR(end.x, 60.0, 1e-12);
    EXPECT_NEAR(end.y, 20.0 + sign * 50.0, 1e-12);
    EXPECT_NEAR(end.hdg, sign * 0.5 * std::numbers::pi, 1e-12);
  }
}

TEST(Plan, nearly_flat_arc_agrees_with_its_series) {
  // A naive (sin(h + k s) - sin(h)) / k loses seven digits here: y = k s^2 / 2 to rounding.
  const PlanElement arc{0.0, 0.0, 0.0, 0.0, 100.0, Arc{1e-10}};
  EXPECT_NEAR(evaluate(arc, 100.0).y, 0.5e-6, 1e-16);
  EXPECT_NEAR(evaluate(arc, 100.0).x, 100.0, 1e-12);
}

/// Heading integrated in many small steps (Simpson), as slow and as plain as can be.
PlanPoint integrate_spiral(double hdg, double k0, double k1, double length_m, double ds) {
  const auto heading = [&](double s) { return hdg + k0 * s + 0.5 * (k1 - k0) / length_m * s * s; };
  const int steps = 20000;
  const double h = ds / steps;
  PlanPoint p;
  for (int i = 0; i < steps; ++i) {
    const double a = heading(i * h), m = heading((i + 0.5) * h), b = heading((i + 1) * h);
    p.x += h / 6.0 * (std::cos(a) + 4.0 * std::cos(m) + std::cos(b));
    p.y += h / 6.0 * (std::sin(a) + 4.0 * std::sin(m) + std::sin(b));
  }
  p.hdg = heading(ds);
  return p;
}

TEST(Plan, spiral_agrees_with_fine_numerical_integration) {
  struct Case {
    double k0, k1, length_m;
  };
  // The last ones turn by 7.5 and by 25 rad (four times around): more than any road.
  for (const Case c : {Case{0.0, 0.01, 80.0}, Case{0.02, -0.03, 120.0}, Case{-0.005, 0.0, 500.0},
                       Case{0.0, 0.03, 500.0}, Case{0.0, 0.1, 500.0}}) {
    const PlanElement spiral{0.0, 0.0, 0.0, 0.7, c.length_m, Spiral{c.k0, c.k1}};
    for (const double f : {0.0, 0.1, 0.5, 1.0}) {
      const PlanPoint got = evaluate(spiral, f * c.length_m);
      const PlanPoint want = integrate_spiral(0.7, c.k0, c.k1, c.length_m, f * c.length_m);
      EXPECT_NEAR(got.x, want.x, 1e-9) << c.k1 << " " << f;
      EXPECT_NEAR(got.y, want.y, 1e-9) << c.k1 << " " << f;
      EXPECT_NEAR(got.hdg, want.hdg, 1e-12);
      EXPECT_NEAR(got.curvature, c.k0 + f * (c.k1 - c.k0), 1e-15);
    }
  }
}

TEST(Plan, spiral_without_length_and_with_constant_curvature) {
  EXPECT_EQ(evaluate(PlanElement{0.0, 1.0, 2.0, 0.3, 0.0, Spiral{0.0, 0.01}}, 0.0).x, 1.0);
  const PlanPoint spiral = evaluate(PlanElement{0.0, 0.0, 0.0, 0.3, 60.0, Spiral{0.02, 0.02}}, 60.0);
  const PlanPoint arc = evaluate(PlanElement{0.0, 0.0, 0.0, 0.3, 60.0, Arc{0.02}}, 60.0);
  EXPECT_NEAR(spiral.x, arc.x, 1e-11);
  EXPECT_NEAR(spiral.y, arc.y, 1e-11);
}

TEST(Plan, param_poly3_in_both_ranges_is_the_same_curve) {
  const double length_m = 40.0;
  const ParamPoly3 by_length{.b_u = 1.0, .c_u = -1e-4, .c_v = 4e-3, .d_v = -3e-5, .normalized = false};
  const ParamPoly3 by_share{.b_u = length_m,
                            .c_u = -1e-4 * length_m * length_m,
                            .c_v = 4e-3 * length_m * length_m,
                            .d_v = -3e-5 * length_m * length_m * length_m,
                            .normalized = true};
  for (const double ds : {0.0, 13.0, 40.0}) {
    const PlanPoint a = evaluate(PlanElement{0.0, 5.0, 6.0, 0.4, length_m, by_length}, ds);
    const PlanPoint b = evaluate(PlanElement{0.0, 5.0, 6.0, 0.4, length_m, by_share}, ds);
    EXPECT_NEAR(a.x, b.x, 1e-11);
    EXPECT_NEAR(a.y, b.y, 1e-11);
    EXPECT_NEAR(a.hdg, b.hdg, 1e-12);
    EXPECT_NEAR(a.curvature, b.curvature, 1e-12);
    EXPECT_NEAR(a.speed, b.speed, 1e-12);
  }
}

TEST(Plan, param_poly3_heading_curvature_and_speed_are_derivatives_of_its_points) {
  const PlanElement poly{
      0.0, 5.0,  6.0,
      2.4, 40.0, ParamPoly3{.b_u = 38.0, .c_u = 1.0, .d_u = 0.5, .c_v = 6.0, .d_v = -3.0, .normalized = true}};
  const double h = 1e-4;
  for (const double ds : {5.0, 20.0, 35.0}) {
    const PlanPoint a = evaluate(poly, ds - h), p = evaluate(poly, ds), b = evaluate(poly, ds + h);
    EXPECT_NEAR(std::hypot(b.x - a.x, b.y - a.y) / (2 * h), p.speed, 1e-7);
    EXPECT_NEAR(std::remainder(std::atan2(b.y - a.y, b.x - a.x) - p.hdg, 2 * std::numbers::pi), 0.0, 1e-7);
    EXPECT_NEAR((b.hdg - a.hdg) / (2 * h), p.curvature * p.speed, 1e-7);
  }
}

TEST(Cubics, value_and_derivative_of_the_right_piece) {
  const std::vector<Cubic> pieces = {{10.0, 1.0, 2.0, 0.0, 0.0}, {20.0, 5.0, 0.0, 1.0, 1.0}};
  EXPECT_EQ(evaluate(std::vector<Cubic>{}, 3.0), 0.0);
  EXPECT_EQ(evaluate(pieces, 9.0), 0.0);  // before the first piece
  EXPECT_EQ(evaluate(pieces, 10.0), 1.0);
  EXPECT_EQ(evaluate(pieces, 12.0), 5.0);
  EXPECT_EQ(evaluate(pieces, 22.0), 5.0 + 4.0 + 8.0);
  EXPECT_EQ(derivative(pieces, 12.0), 2.0);
  EXPECT_EQ(derivative(pieces, 22.0), 4.0 + 12.0);
}

TEST(Lanes, edges_follow_sections_widths_and_lane_offset) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}});
  road.lane_offset = {{.s = 0.0, .a = 0.5}};
  LaneSection wider;
  wider.s = 60.0;
  wider.right = {make_lane(-1, 3.0), make_lane(-2, 2.0)};
  wider.right[1].width[0].b = 0.1;  // 2 m at s = 60, 4 m at s = 80
  road.sections.push_back(wider);
  EXPECT_NEAR(road_edges(road, 30.0).left_t, 4.0, 1e-12);
  EXPECT_NEAR(road_edges(road, 30.0).right_t, -3.0, 1e-12);
  EXPECT_NEAR(road_edges(road, 80.0).left_t, 0.5, 1e-12);
  EXPECT_NEAR(road_edges(road, 80.0).right_t, 0.5 - 3.0 - 4.0, 1e-12);
  EXPECT_EQ(&section_at(road, 60.0), &road.sections[1]);
}

TEST(Surface, positive_superelevation_lifts_the_left_side) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}, 10.0);
  road.superelevation = {{.s = 0.0, .a = 0.05}};
  const SurfacePoint left = surface_point(road, 50.0, 2.0), right = surface_point(road, 50.0, -2.0);
  EXPECT_NEAR(left.z, 10.0 + 2.0 * std::sin(0.05), 1e-12);
  EXPECT_NEAR(right.z, 10.0 - 2.0 * std::sin(0.05), 1e-12);
  EXPECT_NEAR(left.y, 2.0 * std::cos(0.05), 1e-12);
  EXPECT_NEAR(left.normal[1], -std::sin(0.05), 1e-12);
  EXPECT_NEAR(left.normal[2], std::cos(0.05), 1e-12);
}

TEST(Surface, normal_is_the_cross_product_of_numerical_tangents) {
  Road road = make_road(1, {0.0, 3.0, 4.0, 0.6, 100.0, Spiral{0.0, 0.02}});
  road.elevation = {{.s = 0.0, .a = 7.0, .b = 0.06, .c = -4e-4, .d = 2e-6}};
  road.superelevation = {{.s = 0.0, .a = 0.0, .b = 1e-3, .c = -5e-6}};
  const double s = 60.0, t = -3.0, h = 1e-4;
  const SurfacePoint s0 = surface_point(road, s - h, t), s1 = surface_point(road, s + h, t);
  const SurfacePoint t0 = surface_point(road, s, t - h), t1 = surface_point(road, s, t + h);
  const double a[3] = {s1.x - s0.x, s1.y - s0.y, s1.z - s0.z}, b[3] = {t1.x - t0.x, t1.y - t0.y, t1.z - t0.z};
  double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const double norm = std::hypot(n[0], n[1], n[2]);
  const SurfacePoint p = surface_point(road, s, t);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(p.normal[i], n[i] / norm, 1e-7);
}

}  // namespace
}  // namespace roadquery
