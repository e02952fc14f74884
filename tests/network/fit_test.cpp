// SPDX-License-Identifier: Apache-2.0
// Fitting from exact truth: circles, straights, clothoids, profiles.

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>

#include "network_support.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/network/curves/cubic_plan.hpp"
#include "orthodrive/network/curves/fit_plan.hpp"
#include "orthodrive/network/curves/fit_profile.hpp"
#include "orthodrive/network/curves/fit_spline.hpp"

namespace orthodrive::network {
namespace {

using orthodrive::network_test::circle_points;
using roadquery::Arc;
using roadquery::Cubic;
using roadquery::Line;
using roadquery::PlanElement;

double curvature(const PlanElement& e) {
  const Arc* arc = std::get_if<Arc>(&e.shape);
  return arc ? arc->curvature : 0.0;
}

template <typename Shape>
int count(const std::vector<PlanElement>& plan) {
  return static_cast<int>(std::count_if(plan.begin(), plan.end(),
                                        [](const PlanElement& e) { return std::holds_alternative<Shape>(e.shape); }));
}

/// curvature_too: false for biarcs, whose curvature jumps.
void expect_joint(const PlanElement& before, const PlanElement& after, bool curvature_too) {
  const roadquery::PlanPoint a = roadquery::evaluate(before, before.length), b = roadquery::evaluate(after, 0.0);
  EXPECT_LT(std::hypot(a.x - b.x, a.y - b.y), 2e-8);
  EXPECT_LT(std::abs(std::remainder(a.hdg - b.hdg, 2.0 * M_PI)), 1e-8);
  if (curvature_too) {
    EXPECT_NEAR(a.curvature, b.curvature, 1e-8);
  }
}

/// Neither gap nor kink nor jump of curvature, also from the end of a closed plan to its start.
void expect_smooth(const std::vector<PlanElement>& plan, bool closed = false, bool curvature_too = true) {
  ASSERT_FALSE(plan.empty());
  EXPECT_EQ(plan.front().s, 0.0);
  for (std::size_t i = 1; i < plan.size(); ++i) {
    expect_joint(plan[i - 1], plan[i], curvature_too);
    EXPECT_NEAR(plan[i].s, plan[i - 1].s + plan[i - 1].length, 1e-9);
  }
  if (closed) expect_joint(plan.back(), plan.front(), curvature_too);
}

/// What must hold for any points: smooth, feet in order, as near as stated.
void expect_fits(const PlanFit& fit, const std::vector<Vec2>& points, const FitPlanOptions& options) {
  expect_smooth(fit.elements, options.closed);
  ASSERT_EQ(fit.point_s.size(), points.size());
  EXPECT_EQ(fit.point_s.front(), 0.0);
  EXPECT_NEAR(fit.point_s.back(), plan_length(fit.elements), 1e-9);
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) {
      EXPECT_GE(fit.point_s[i], fit.point_s[i - 1]);
    }
    farthest = std::max(farthest, distance(pose_at(fit.elements, fit.point_s[i]).p, points[i]));
  }
  EXPECT_LE(farthest, options.tolerance_m + 0.005);  // at the ends the foot may lie beyond
  EXPECT_LE(fit.max_deviation_m, options.tolerance_m);
}

/// A road of (length, curvature at its start, at its end), sampled every 2 m, in UTM coordinates.
struct LineStretch {
  double length, k0, k1;
};
std::vector<PlanElement> plan_of(const std::vector<LineStretch>& stretches,
                                 Vec2 start = orthodrive::network_test::site_origin) {
  std::vector<PlanElement> plan;
  PlanElement next{.x = start.x, .y = start.y, .hdg = 0.4};
  for (const LineStretch& stretch : stretches) {
    next.length = stretch.length;
    next.shape = roadquery::Spiral{stretch.k0, stretch.k1};
    plan.push_back(next);
    const roadquery::PlanPoint end = roadquery::evaluate(next, next.length);
    next = {next.s + next.length, end.x, end.y, end.hdg};
  }
  return plan;
}
std::vector<Vec2> sample(const std::vector<PlanElement>& plan, double noise_m = 0.0, double step_m = 2.0) {
  Random random(7);
  std::vector<Vec2> points;
  const int n = static_cast<int>(std::round(plan_length(plan) / step_m));
  for (int i = 0; i <= n; ++i) {
    const Pose pose = pose_at(plan, plan_length(plan) * i / n);
    points.push_back(pose.p + left_normal(pose.direction) * random.uniform(-1.7, 1.7) * noise_m);  // sigma = noise
  }
  return points;
}
/// Two bends with transitions as roads have them: 9 elements.
const std::vector<LineStretch> s_bend{{120, 0, 0},    {40, 0, 0.01},      {90, 0.01, 0.01}, {40, 0.01, 0}, {60, 0, 0},
                                      {30, 0, -0.02}, {50, -0.02, -0.02}, {30, -0.02, 0},   {120, 0, 0}};

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
  points.reserve(50);
  for (int i = 0; i < 50; ++i) points.push_back({2.0 * i - 100.0, 0.0});
  for (const Vec2 p : circle_points({0.0, 30.0}, 30.0, -M_PI / 2.0, M_PI / 2.0)) points.push_back(p);
  for (int i = 1; i <= 50; ++i) points.push_back({30.0, 30.0 + 2.0 * i});
  const PlanFit fit = fit_plan(points, {.tolerance_m = 0.05});
  expect_smooth(fit.elements);
  EXPECT_LE(fit.max_deviation_m, 0.05);
  EXPECT_LE(fit.elements.size(), 12u);
  // The curvature of the nodes jumps, that of the line may not: a short clothoid at both ends of the bend.
  double turn = 0.0, straight = 0.0, sharpest = 0.0;
  for (const PlanElement& e : fit.elements) {
    const double k0 = roadquery::evaluate(e, 0.0).curvature, k1 = roadquery::evaluate(e, e.length).curvature;
    turn += 0.5 * (k0 + k1) * e.length;
    sharpest = std::max({sharpest, std::abs(k0), std::abs(k1)});
    if (std::abs(k0) + std::abs(k1) < 1e-4) straight += e.length;
  }
  EXPECT_NEAR(turn, M_PI / 2.0, 2e-3);
  EXPECT_GT(straight, 170.0);
  EXPECT_LT(sharpest, 1.1 / 30.0);
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

TEST(FitPlan, road_of_lines_arcs_and_clothoids_is_recovered) {
  const std::vector<PlanElement> truth = plan_of(s_bend);
  for (const double noise_m : {0.0, 0.02}) {
    const std::vector<Vec2> points = sample(truth, noise_m);
    const FitPlanOptions options{.tolerance_m = 0.08};
    const PlanFit fit = fit_plan(points, options);
    expect_fits(fit, points, options);
    EXPECT_LE(fit.elements.size(), 9u) << "noise " << noise_m;
    EXPECT_GE(count<Line>(fit.elements), 2) << "noise " << noise_m;
    double worst_m = 0.0, worst_k = 0.0;
    for (double s = 0.0; s <= plan_length(truth); s += 1.0) {
      const double at = s * plan_length(fit.elements) / plan_length(truth);
      const Pose a = pose_at(truth, s), b = pose_at(fit.elements, at);
      worst_m = std::max(worst_m, std::abs(cross(a.direction, b.p - a.p)));
      const auto curvature_at = [](const std::vector<PlanElement>& plan, double u) {
        roadquery::Road road{.length = plan_length(plan), .plan = plan};
        return roadquery::reference_point(road, u).curvature;
      };
      worst_k = std::max(worst_k, std::abs(curvature_at(truth, s) - curvature_at(fit.elements, at)));
    }
    EXPECT_LT(worst_m, 0.09);
    EXPECT_LT(worst_k, 0.004) << "wiggles";  // the sharper bend has 0.02
  }
}

TEST(FitPlan, closed_road_is_smooth_through_its_seam) {
  // An oval whose first point lies in the middle of a clothoid.
  std::vector<PlanElement> oval = plan_of({{30, 0.005, 0.01},
                                           {M_PI / 0.01 - 60.0, 0.01, 0.01},
                                           {60, 0.01, 0},
                                           {200, 0, 0},
                                           {60, 0, 0.01},
                                           {M_PI / 0.01 - 60.0, 0.01, 0.01},
                                           {60, 0.01, 0},
                                           {200, 0, 0},
                                           {30, 0, 0.005}});
  std::vector<Vec2> points = sample(oval, 0.02);
  ASSERT_LT(distance(points.front(), points.back()), 0.2);
  points.back() = points.front();
  const FitPlanOptions options{.tolerance_m = 0.08, .closed = true};
  const PlanFit fit = fit_plan(points, options);
  expect_fits(fit, points, options);
  EXPECT_LE(fit.elements.size(), 12u);
}

TEST(FitPlan, closed_circle_with_noise_is_two_arcs_either_way_round) {
  Random random(2);
  for (const double turn : {2.0 * M_PI, -2.0 * M_PI}) {
    std::vector<Vec2> points = circle_points({3.0, 9.0}, 14.0, 0.7, turn);
    for (Vec2& p : points) p = p + Vec2{random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03)};
    points.back() = points.front();
    const FitPlanOptions options{.tolerance_m = 0.08, .closed = true};
    const PlanFit fit = fit_plan(points, options);
    expect_fits(fit, points, options);
    EXPECT_EQ(count<Arc>(fit.elements), 2);
    EXPECT_EQ(fit.elements.size(), 2u);
    EXPECT_NEAR(curvature(fit.elements[0]), std::copysign(1.0 / 14.0, turn), 2e-4);
  }
}

TEST(FitPlan, figure_of_eight_and_spiral_inwards) {
  std::vector<Vec2> eight;
  for (int i = 0; i <= 300; ++i) {
    const double t = 2.0 * M_PI * i / 300.0;
    eight.push_back({80.0 * std::sin(t), 40.0 * std::sin(2.0 * t)});
  }
  eight.back() = eight.front();
  FitPlanOptions options{.tolerance_m = 0.05, .closed = true};
  const PlanFit round = fit_plan(eight, options);
  expect_fits(round, eight, options);
  EXPECT_LE(round.elements.size(), 40u);
  const std::vector<Vec2> inwards = sample(plan_of({{300, 0.0, 0.2}}));
  options.closed = false;
  const PlanFit fit = fit_plan(inwards, options);
  expect_fits(fit, inwards, options);
  EXPECT_LE(fit.elements.size(), 2u);
}

TEST(FitPlan, sharp_corners_stay_within_the_tolerance) {
  // A polygon of 90 and 150 degrees with nodes every 2 m, rounded by nothing.
  std::vector<Vec2> points;
  const std::vector<Vec2> corners{{0, 0}, {30, 0}, {30, 25}, {8, 12}, {40, 12}};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const int n = static_cast<int>(distance(corners[i], corners[i + 1]) / 2.0);
    for (int k = i == 0 ? 0 : 1; k <= n; ++k)
      points.push_back(corners[i] + (corners[i + 1] - corners[i]) * (1.0 * k / n));
  }
  const FitPlanOptions options{.tolerance_m = 0.08};
  const PlanFit fit = fit_plan(points, options);
  expect_fits(fit, points, options);
  EXPECT_LT(plan_length(fit.elements), 120.0) << "it swings wide between the nodes";
}

TEST(FitPlan, three_points_and_uneven_spacing) {
  for (const std::vector<Vec2>& points :
       {std::vector<Vec2>{{0, 0}, {0.3, 0.01}, {3.0, 0.4}},
        std::vector<Vec2>{{0, 0}, {3.0, 0.0}, {3.3, 0.1}, {6.0, 1.0}, {6.25, 1.2}, {9.0, 4.0}}}) {
    const FitPlanOptions options{.tolerance_m = 0.05};
    expect_fits(fit_plan(points, options), points, options);
  }
}

TEST(FitPlan, reversed_points_give_a_line_as_near_and_about_as_short) {
  std::vector<Vec2> points = sample(plan_of(s_bend), 0.02);
  const FitPlanOptions options{.tolerance_m = 0.08};
  const PlanFit there = fit_plan(points, options);
  std::reverse(points.begin(), points.end());
  const PlanFit back = fit_plan(points, options);
  expect_fits(back, points, options);
  EXPECT_NEAR(static_cast<double>(back.elements.size()), static_cast<double>(there.elements.size()), 2.0);
  EXPECT_NEAR(plan_length(back.elements), plan_length(there.elements), 0.01);
}

/// Fits a line of `s_bends` bends; seconds of processor time.
double fit_long_line(int s_bends) {
  std::vector<LineStretch> stretches;
  for (int i = 0; i < s_bends; ++i) stretches.insert(stretches.end(), s_bend.begin(), s_bend.end());
  const std::vector<Vec2> points = sample(plan_of(stretches));
  EXPECT_GT(points.size(), 238u * static_cast<std::size_t>(s_bends));
  const FitPlanOptions options{.tolerance_m = 0.08};
  const auto start = std::clock();
  const PlanFit fit = fit_plan(points, options);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  expect_fits(fit, points, options);
  EXPECT_LE(fit.elements.size(), static_cast<std::size_t>(s_bends) * 9u);
  return seconds;
}

TEST(FitPlan, long_line_costs_by_its_length) {
  const double quarter = fit_long_line(105);
  const double whole = fit_long_line(420);
  EXPECT_LT(whole, 8.0 * quarter);  // 4 by its length, 16 by its square
#ifndef __SANITIZE_ADDRESS__        // several times slower
  EXPECT_LT(whole, 8.0);
#endif
}

TEST(FitPlan, two_points_give_their_line) {
  const std::vector<Vec2> points{{1.0, 1.0}, {1.0, 4.0}};
  const PlanFit fit = fit_plan(points);
  ASSERT_EQ(fit.elements.size(), 1u);
  EXPECT_NEAR(fit.elements[0].length, 3.0, 1e-12);
}

TEST(Biarc, meets_both_poses_whatever_they_are) {
  Random random(5);
  int clothoids = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto pose = [&] {
      const double heading = random.uniform(-M_PI, M_PI);
      return Pose{{random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0)}, {std::cos(heading), std::sin(heading)}};
    };
    const Pose a = pose(), b = pose();
    for (const std::vector<PlanElement>& elements : {biarc(a, b), turn(a, b)}) {
      expect_smooth(elements, false, false);
      const Pose start = pose_at(elements, 0.0), end = pose_at(elements, plan_length(elements));
      ASSERT_LT(distance(start.p, a.p), 1e-7);
      ASSERT_LT(distance(end.p, b.p), 1e-6);
      ASSERT_GT(dot(start.direction, a.direction), 1.0 - 1e-9);
      ASSERT_GT(dot(end.direction, b.direction), 1.0 - 1e-9);
      clothoids += count<roadquery::Spiral>(elements);
    }
  }
  EXPECT_GT(clothoids, 500);  // of the turns
}

TEST(SlicePlan, slices_and_reversed_plans_lie_on_the_line) {
  const std::vector<PlanElement> plan = fit_plan(sample(plan_of(s_bend)), {.tolerance_m = 0.08}).elements;
  EXPECT_GT(count<roadquery::Spiral>(plan), 2);
  const double s0 = 131.0, s1 = 481.5;
  const std::vector<PlanElement> part = slice_plan(plan, s0, s1), back = reverse_plan(part);
  EXPECT_NEAR(plan_length(part), s1 - s0, 1e-9);
  expect_smooth(part);
  expect_smooth(back);
  for (double s = 0.0; s <= s1 - s0; s += 0.7) {
    const Pose expected = pose_at(plan, s0 + s), a = pose_at(part, s), b = pose_at(back, s1 - s0 - s);
    EXPECT_LT(distance(a.p, expected.p), 1e-8);
    EXPECT_LT(distance(b.p, expected.p), 1e-8);
    EXPECT_LT(dot(b.direction, expected.direction), -1.0 + 1e-9);
  }
}

TEST(CubicPlan, goes_through_all_points_without_jump_of_curvature) {
  std::vector<Vec2> points = circle_points({500.0, 700.0}, 20.0, 0.0, 2.0 * M_PI);
  points[3] = points[3] + Vec2{0.4, 0.2};
  points.back() = points.front();
  for (const bool closed : {true, false}) {
    const std::vector<PlanElement> plan = cubic_plan(points, closed);
    ASSERT_EQ(plan.size(), points.size() - 1);
    expect_smooth(plan, closed);
    for (std::size_t i = 0; i < plan.size(); ++i) EXPECT_LT(distance({plan[i].x, plan[i].y}, points[i]), 1e-9);
    const std::vector<PlanElement> part = slice_plan(plan, 11.0, 61.5), back = reverse_plan(part);
    expect_smooth(part);
    expect_smooth(back);
    for (double s = 0.0; s <= 50.5; s += 0.7) {
      EXPECT_LT(distance(pose_at(part, s).p, pose_at(plan, 11.0 + s).p), 1e-8);
      EXPECT_LT(distance(pose_at(back, 50.5 - s).p, pose_at(plan, 11.0 + s).p), 1e-8);
    }
  }
}

double hill(double s) { return 5.0 * std::sin(s / 40.0) + 0.03 * s; }

/// Value and slope go on at every joint.
void expect_joined(const std::vector<Cubic>& cubics) {
  for (std::size_t i = 1; i < cubics.size(); ++i) {
    const std::span<const Cubic> before(cubics.data(), i);
    EXPECT_NEAR(roadquery::evaluate(before, cubics[i].s), cubics[i].a, 1e-9);
    EXPECT_NEAR(roadquery::derivative(before, cubics[i].s), cubics[i].b, 1e-9);
  }
}

TEST(FitProfile, follows_a_hill_with_few_cubics) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i <= 250; ++i) samples.push_back({2.0 * i, hill(2.0 * i)});
  const ProfileFit fit = fit_profile(samples, {.tolerance = 0.02});
  EXPECT_LT(fit.cubics.size(), 20u);
  EXPECT_LE(fit.max_error, 0.02);
  for (double s = 0.0; s <= 500.0; s += 0.5) EXPECT_NEAR(roadquery::evaluate(fit.cubics, s), hill(s), 0.025) << s;
  expect_joined(fit.cubics);
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

TEST(FitProfile, is_level_at_both_ends_where_that_is_asked) {
  const std::vector<ProfileSample> samples{{0.0, 6.0}, {9.0, 6.5}, {20.0, 7.5}, {31.0, 9.0}};
  const ProfileFit fit = fit_profile(samples, {.level_ends = true});
  expect_joined(fit.cubics);
  for (const double s : {0.0, 31.0}) EXPECT_NEAR(roadquery::derivative(fit.cubics, s), 0.0, 1e-12);
  for (const ProfileSample& sample : samples)
    EXPECT_NEAR(roadquery::evaluate(fit.cubics, sample.s), sample.value, 0.02);
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
  expect_joined(fit.cubics);
  for (std::size_t i = 1; i < fit.cubics.size(); ++i) {
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
  noise.reserve(80);
  for (int i = 0; i < 80; ++i) noise.push_back({1.7 * i, random.normal()});
  EXPECT_LE(fit_spline(noise, {.tolerance = 0.01}).max_error, 0.01);
  EXPECT_EQ(fit_spline(std::vector<ProfileSample>{{3.0, 1.5}}).cubics.size(), 1u);
  EXPECT_NEAR(roadquery::evaluate(fit_spline(std::vector<ProfileSample>{{0.0, 1.0}, {10.0, 3.0}}).cubics, 5.0), 2.0,
              1e-12);
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
