// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace orthodrive::synth {
namespace {

/// Slow and simple: the midpoint rule with many steps.
Vec2 integrate(const AlignmentElement& e) {
  constexpr int steps = 400000;
  const double h = e.length_m / steps, slope = (e.k_end_1pm - e.k_begin_1pm) / e.length_m;
  Vec2 p = e.start;
  for (int i = 0; i < steps; ++i) {
    const double s = (i + 0.5) * h, heading = e.heading_rad + s * (e.k_begin_1pm + 0.5 * slope * s);
    p = p + Vec2{std::cos(heading), std::sin(heading)} * h;
  }
  return p;
}

TEST(Alignment, clothoid_ends_where_numerical_integration_ends) {
  for (const AlignmentElement& e :
       {AlignmentElement{.length_m = 80.0, .start = {3.0, -4.0}, .heading_rad = 0.7, .k_end_1pm = 1.0 / 40.0},
        AlignmentElement{.length_m = 120.0, .heading_rad = -2.0, .k_begin_1pm = 0.03, .k_end_1pm = -0.05},
        AlignmentElement{.length_m = 200.0, .heading_rad = 1.0, .k_begin_1pm = 0.1, .k_end_1pm = 0.1}})
    EXPECT_LT(distance(evaluate(e, e.length_m).p, integrate(e)), 1e-7);
}

TEST(Alignment, arc_is_a_circle) {
  const AlignmentElement quarter{.length_m = 50.0 * std::numbers::pi, .k_begin_1pm = 0.01, .k_end_1pm = 0.01};
  EXPECT_LT(distance(evaluate(quarter, quarter.length_m).p, {100.0, 100.0}), 1e-10);
}

void expect_continuous(const Alignment& a) {
  const std::size_t joints = a.closed ? a.elements.size() : a.elements.size() - 1;
  for (std::size_t i = 0; i < joints; ++i) {
    const AlignmentPoint end = evaluate(a.elements[i], a.elements[i].length_m);
    const AlignmentElement& next = a.elements[(i + 1) % a.elements.size()];
    EXPECT_LT(distance(end.p, next.start), 1e-8) << "joint " << i;
    EXPECT_NEAR(std::remainder(end.heading_rad - next.heading_rad, 2.0 * std::numbers::pi), 0.0, 1e-10)
        << "joint " << i;
    EXPECT_NEAR(end.curvature_1pm, next.k_begin_1pm, 1e-12) << "joint " << i;
    EXPECT_GE(a.elements[i].length_m, 0.0) << "element " << i;
  }
}

TEST(Alignment, corners_are_rounded_without_a_jump_in_curvature) {
  const Alignment open =
      round_corners({{{0, 0}, 0}, {{200, 0}, 60}, {{250, 180}, 90}, {{400, 120}, 30}, {{600, 300}, 0}}, false);
  expect_continuous(open);
  EXPECT_LT(distance(evaluate(open, 0.0).p, {0, 0}), 1e-9);
  EXPECT_LT(distance(evaluate(open, open.length_m).p, {600, 300}), 1e-8);
}

TEST(Alignment, closed_ring_closes) {
  const Alignment ring =
      round_corners({{{0, 0}, 60}, {{300, 20}, 60}, {{250, 200}, 500}, {{120, 120}, 40}, {{20, 260}, 80}}, true);
  expect_continuous(ring);
  EXPECT_LT(distance(evaluate(ring, ring.length_m - 1e-9).p, evaluate(ring, 0.0).p), 1e-8);
  EXPECT_LT(distance(evaluate(ring, -5.0).p, evaluate(ring, ring.length_m - 5.0).p), 1e-9);
}

TEST(Alignment, radius_shrinks_where_the_tangents_are_short) {
  const Alignment tight = round_corners({{{0, 0}, 0}, {{20, 0}, 1000}, {{20, 20}, 1000}, {{40, 20}, 0}}, false);
  expect_continuous(tight);
}

TEST(Alignment, straight_through_corner_stays_straight) {
  const Alignment line = round_corners({{{0, 0}, 0}, {{50, 0}, 30}, {{100, 0}, 0}}, false);
  EXPECT_NEAR(line.length_m, 100.0, 1e-9);
  EXPECT_LT(distance(evaluate(line, 70.0).p, {70, 0}), 1e-9);
}

TEST(Alignment, crossings_lie_on_both) {
  const Alignment a = round_corners({{{0, 0}, 0}, {{100, 50}, 40}, {{200, 0}, 0}}, false);
  const Alignment b = round_corners({{{100, -50}, 0}, {{90, 20}, 40}, {{120, 100}, 0}}, false);
  const auto found = crossings(a, b);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT(distance(evaluate(a, found[0].s_a_m).p, evaluate(b, found[0].s_b_m).p), 1e-9);
}

TEST(Alignment, nearest_is_perpendicular) {
  const Alignment a = round_corners({{{0, 0}, 0}, {{100, 50}, 40}, {{200, 0}, 0}}, false);
  const AlignmentPoint q = evaluate(a, nearest_s(a, {110.0, 20.0}));
  EXPECT_NEAR(dot(Vec2{110.0, 20.0} - q.p, {std::cos(q.heading_rad), std::sin(q.heading_rad)}), 0.0, 1e-8);
}

}  // namespace
}  // namespace orthodrive::synth
