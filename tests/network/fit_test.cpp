// Fitting from exact truth: circles, straights, profiles.

#include <gtest/gtest.h>

#include "network_support.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/network/fit_plan.hpp"
#include "orthodrive/network/fit_profile.hpp"
#include "orthodrive/network/fit_spline.hpp"

namespace orthodrive::network {
namespace {

using orthodrive::testing::circle_points;
using roadquery::Arc;
using roadquery::Cubic;
using roadquery::Line;
using roadquery::PlanElement;

double curvature(const PlanElement& e) {
  const Arc* arc = std::get_if<Arc>(&e.shape);
  return arc ? arc->curvature : 0.0;
}

void expect_smooth(const std::vector<PlanElement>& plan) {
  for (std::size_t i = 1; i < plan.size(); ++i) {
    const Pose a = pose_at(std::span(plan).first(i), plan[i].s);
    EXPECT_LT(distance(a.p, {plan[i].x, plan[i].y}), 1e-7);
    EXPECT_LT(std::abs(cross(a.direction, {std::cos(plan[i].hdg), std::sin(plan[i].hdg)})), 1e-7);
    EXPECT_NEAR(plan[i].s, plan[i - 1].s + plan[i - 1].length, 1e-9);
  }
}

TEST(FitPlan, straight_points_give_one_line) {
  std::vector<Vec2> points;
  for (int i = 0; i <= 50; ++i) points.push_back(Vec2{650000.0 + 1.6 * i, 6400000.0 + 1.2 * i});
  const PlanFit fit = fit_plan(points);
  ASSERT_EQ(fit.elements.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<Line>(fit.elements[0].shape));
  EXPECT_NEAR(fit.elements[0].length, 100.0, 1e-6);
  EXPECT_NEAR(fit.elements[0].hdg, std::atan2(1.2, 1.6), 1e-9);
}

TEST(FitPlan, noise_of_a_straight_stays_a_line) {
  Random random(3);
  std::vector<Vec2> points;
  for (int i = 0; i <= 100; ++i) points.push_back({2.0 * i, random.uniform(-0.01, 0.01)});
  const PlanFit fit = fit_plan(points);
  double straight = 0.0;
  for (const PlanElement& e : fit.elements)
    if (std::holds_alternative<Line>(e.shape)) straight += e.length;
  EXPECT_GT(straight, 190.0);
  EXPECT_LT(fit.elements.size(), 6u);
  expect_smooth(fit.elements);
}

TEST(FitPlan, circle_points_give_one_arc_of_that_radius) {
  for (const double turn : {1.5, -1.5}) {
    const PlanFit fit = fit_plan(circle_points({500.0, 700.0}, 50.0, 0.3, turn));
    ASSERT_EQ(fit.elements.size(), 1u);
    EXPECT_NEAR(curvature(fit.elements[0]), turn > 0.0 ? 0.02 : -0.02, 1e-9);
    EXPECT_NEAR(fit.elements[0].length, 75.0, 1e-6);
  }
}

TEST(FitPlan, line_arc_line_stays_within_the_tolerance) {
  // 100 m straight, 90 degrees to the left with 30 m radius, 100 m straight.
  std::vector<Vec2> points;
  for (int i = 0; i < 50; ++i) points.push_back({2.0 * i - 100.0, 0.0});
  for (const Vec2 p : circle_points({0.0, 30.0}, 30.0, -M_PI / 2.0, M_PI / 2.0)) points.push_back(p);
  for (int i = 1; i <= 50; ++i) points.push_back({30.0, 30.0 + 2.0 * i});
  const PlanFit fit = fit_plan(points, {.tolerance_m = 0.05});
  expect_smooth(fit.elements);
  EXPECT_LE(fit.max_deviation_m, 0.05);
  EXPECT_LE(fit.elements.size(), 12u);
  double turn = 0.0, straight = 0.0, sharpest = 0.0;
  for (const PlanElement& e : fit.elements) {
    turn += curvature(e) * e.length;
    sharpest = std::max(sharpest, std::abs(curvature(e)));
    if (curvature(e) == 0.0) straight += e.length;
  }
  EXPECT_NEAR(turn, M_PI / 2.0, 1e-6);
  EXPECT_GT(straight, 170.0);
  EXPECT_LT(sharpest, 1.5 / 30.0);
  EXPECT_NEAR(curvature(fit.elements[fit.elements.size() / 2]), 1.0 / 30.0, 2e-3);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(distance(pose_at(fit.elements, fit.point_s[i]).p, points[i]), 0.0501) << i;
}

TEST(FitPlan, closed_circle_joins_itself) {
  std::vector<Vec2> points = circle_points({0.0, 0.0}, 40.0, 0.7, 2.0 * M_PI);
  points.back() = points.front();
  const PlanFit fit = fit_plan(points, {.closed = true});
  expect_smooth(fit.elements);
  const Pose start = pose_at(fit.elements, 0.0), end = pose_at(fit.elements, plan_length(fit.elements));
  EXPECT_LT(distance(start.p, end.p), 1e-6);
  EXPECT_LT(std::abs(cross(start.direction, end.direction)), 1e-7);
  EXPECT_NEAR(plan_length(fit.elements), 2.0 * M_PI * 40.0, 1e-4);
}

TEST(FitPlan, two_points_give_their_line) {
  const std::vector<Vec2> points{{1.0, 1.0}, {1.0, 4.0}};
  const PlanFit fit = fit_plan(points);
  ASSERT_EQ(fit.elements.size(), 1u);
  EXPECT_NEAR(fit.elements[0].length, 3.0, 1e-12);
}

TEST(Biarc, meets_both_poses_whatever_they_are) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const auto pose = [&] {
      const double heading = random.uniform(-M_PI, M_PI);
      return Pose{{random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0)}, {std::cos(heading), std::sin(heading)}};
    };
    const Pose a = pose(), b = pose();
    const std::vector<PlanElement> elements = biarc(a, b);
    expect_smooth(elements);
    const Pose start = pose_at(elements, 0.0), end = pose_at(elements, plan_length(elements));
    ASSERT_LT(distance(start.p, a.p), 1e-7);
    ASSERT_LT(distance(end.p, b.p), 1e-6);
    ASSERT_GT(dot(start.direction, a.direction), 1.0 - 1e-9);
    ASSERT_GT(dot(end.direction, b.direction), 1.0 - 1e-9);
  }
}

TEST(SlicePlan, slices_and_reversed_plans_lie_on_the_line) {
  std::vector<Vec2> points = circle_points({0.0, 0.0}, 30.0, 0.0, 1.2);
  for (int i = 1; i < 30; ++i) points.push_back(points.back() + Vec2{-1.0, 1.5});
  const std::vector<PlanElement> plan = fit_plan(points).elements;
  const std::vector<PlanElement> part = slice_plan(plan, 11.0, 61.5), back = reverse_plan(part);
  EXPECT_NEAR(plan_length(part), 50.5, 1e-9);
  expect_smooth(part);
  expect_smooth(back);
  for (double s = 0.0; s <= 50.5; s += 0.7) {
    const Pose expected = pose_at(plan, 11.0 + s), a = pose_at(part, s), b = pose_at(back, 50.5 - s);
    EXPECT_LT(distance(a.p, expected.p), 1e-8);
    EXPECT_LT(distance(b.p, expected.p), 1e-8);
    EXPECT_LT(dot(b.direction, expected.direction), -1.0 + 1e-9);
  }
}

double hill(double s) { return 5.0 * std::sin(s / 40.0) + 0.03 * s; }

TEST(FitProfile, follows_a_hill_with_few_cubics) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i <= 250; ++i) samples.push_back({2.0 * i, hill(2.0 * i)});
  const ProfileFit fit = fit_profile(samples, {.tolerance = 0.02});
  EXPECT_LT(fit.cubics.size(), 20u);
  EXPECT_LE(fit.max_error, 0.02);
  for (double s = 0.0; s <= 500.0; s += 0.5) EXPECT_NEAR(roadquery::evaluate(fit.cubics, s), hill(s), 0.025) << s;
  for (std::size_t i = 1; i < fit.cubics.size(); ++i) {
    const std::span<const Cubic> before(fit.cubics.data(), i);
    EXPECT_NEAR(roadquery::evaluate(before, fit.cubics[i].s), fit.cubics[i].a, 1e-9);
    EXPECT_NEAR(roadquery::derivative(before, fit.cubics[i].s), fit.cubics[i].b, 1e-9);
  }
}

TEST(FitProfile, constant_line_and_single_sample) {
  const std::vector<ProfileSample> flat{{0.0, 6.0}, {2.0, 6.0}, {4.0, 6.0}, {90.0, 6.0}};
  EXPECT_EQ(fit_profile(flat).cubics.size(), 1u);
  EXPECT_DOUBLE_EQ(roadquery::evaluate(fit_profile(flat).cubics, 45.0), 6.0);
  const std::vector<ProfileSample> one{{3.0, 1.5}};
  EXPECT_DOUBLE_EQ(roadquery::evaluate(fit_profile(one).cubics, 7.0), 1.5);
}

TEST(FitProfile, closed_profile_goes_on_with_the_same_slope) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i <= 100; ++i) samples.push_back({2.0 * i, std::sin(2.0 * M_PI * i / 100.0)});
  samples.back().value = samples.front().value;
  const ProfileFit fit = fit_profile(samples, {.tolerance = 0.01, .closed = true});
  EXPECT_NEAR(roadquery::derivative(fit.cubics, 200.0), roadquery::derivative(fit.cubics, 0.0), 1e-9);
  EXPECT_NEAR(roadquery::derivative(fit.cubics, 0.0), 2.0 * M_PI / 200.0, 5e-4);
}

TEST(FitProfile, slices_and_reversed_profiles_have_the_same_values) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i <= 60; ++i) samples.push_back({2.0 * i, hill(2.0 * i)});
  const std::vector<Cubic> cubics = fit_profile(samples).cubics;
  const std::vector<Cubic> part = slice_profile(cubics, 13.0, 99.0), back = reverse_profile(part, 86.0, -1.0);
  for (double s = 0.0; s <= 86.0; s += 0.9) {
    EXPECT_NEAR(roadquery::evaluate(part, s), roadquery::evaluate(cubics, s + 13.0), 1e-9);
    EXPECT_NEAR(roadquery::evaluate(back, 86.0 - s), -roadquery::evaluate(cubics, s + 13.0), 1e-9);
  }
}

/// Second derivative at the end of the piece before and at the start of the piece itself.
std::pair<double, double> curvatures_at(const std::vector<Cubic>& cubics, std::size_t i) {
  const Cubic& before = cubics[i - 1];
  return {2.0 * before.c + 6.0 * before.d * (cubics[i].s - before.s), 2.0 * cubics[i].c};
}

TEST(FitSpline, follows_a_hill_with_continuous_curvature) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i <= 250; ++i) samples.push_back({2.0 * i, hill(2.0 * i)});
  const ProfileFit fit = fit_spline(samples, {.tolerance = 0.02});
  EXPECT_LT(fit.cubics.size(), 40u);
  EXPECT_LE(fit.max_error, 0.02);
  for (double s = 0.0; s <= 500.0; s += 0.5) EXPECT_NEAR(roadquery::evaluate(fit.cubics, s), hill(s), 0.025) << s;
  for (std::size_t i = 1; i < fit.cubics.size(); ++i) {
    const std::span<const Cubic> before(fit.cubics.data(), i);
    EXPECT_NEAR(roadquery::evaluate(before, fit.cubics[i].s), fit.cubics[i].a, 1e-9);
    EXPECT_NEAR(roadquery::derivative(before, fit.cubics[i].s), fit.cubics[i].b, 1e-9);
    const auto [end, start] = curvatures_at(fit.cubics, i);
    EXPECT_NEAR(end, start, 1e-9);
  }
}

TEST(FitSpline, a_line_is_one_cubic_and_noise_is_followed) {
  const std::vector<ProfileSample> line{{0.0, 6.0}, {2.0, 6.1}, {4.0, 6.2}, {50.0, 8.5}};
  const ProfileFit fit = fit_spline(line);
  ASSERT_EQ(fit.cubics.size(), 1u);
  EXPECT_NEAR(roadquery::evaluate(fit.cubics, 30.0), 7.5, 1e-9);
  Random random(2);
  std::vector<ProfileSample> noise;
  for (int i = 0; i < 80; ++i) noise.push_back({1.7 * i, random.normal()});
  EXPECT_LE(fit_spline(noise, {.tolerance = 0.01}).max_error, 0.01);
  EXPECT_EQ(fit_spline(std::vector<ProfileSample>{{3.0, 1.5}}).cubics.size(), 1u);
  EXPECT_NEAR(roadquery::evaluate(fit_spline(std::vector<ProfileSample>{{0.0, 1.0}, {10.0, 3.0}}).cubics, 5.0), 2.0, 1e-12);
}

TEST(FitSpline, closed_profile_goes_on_with_the_same_curvature) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i <= 100; ++i) samples.push_back({2.0 * i, std::sin(2.0 * M_PI * (i % 100) / 100.0 + 0.5)});
  const ProfileFit fit = fit_spline(samples, {.tolerance = 0.005, .closed = true});
  const Cubic& last = fit.cubics.back();
  const double h = 200.0 - last.s;
  EXPECT_NEAR(last.b + h * (2.0 * last.c + 3.0 * h * last.d), fit.cubics.front().b, 1e-9);
  EXPECT_NEAR(2.0 * last.c + 6.0 * h * last.d, 2.0 * fit.cubics.front().c, 1e-9);
  EXPECT_NEAR(fit.cubics.front().b, 2.0 * M_PI / 200.0 * std::cos(0.5), 1e-3);
}

}  // namespace
}  // namespace orthodrive::network
