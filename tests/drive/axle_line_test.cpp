// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/axle_line.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/drive/car/steering_limits.hpp"
#include "orthodrive/drive/line/bounded_line.hpp"
#include "orthodrive/drive/line/driving_line.hpp"

namespace orthodrive {
namespace {

using namespace test;
constexpr double wheelbase_m = 2.6;

/// A point every half metre of a circle to the left.
DrivingLine circle_line(double radius_m) {
  const int n = static_cast<int>(std::lround(4.0 * std::numbers::pi * radius_m));
  std::vector<Vec2> points;
  for (int i = 0; i < n; ++i) {
    const double a = 2.0 * std::numbers::pi * i / n;
    points.push_back({radius_m * std::cos(a), radius_m * std::sin(a)});
  }
  return plain_line(points, true);
}

TEST(AxleLine, on_a_circle_the_rear_axle_runs_within_and_the_front_axle_without) {
  for (const double radius_m : {4.0, 8.0, 50.0}) {
    const DrivingLine line = circle_line(radius_m);
    const std::vector<double> heading = car_headings(line, wheelbase_m);
    const DrivingLine front = front_axle_line(line, wheelbase_m, heading);
    const double rear_m = std::sqrt(radius_m * radius_m - 0.25 * wheelbase_m * wheelbase_m);
    const std::vector<double> angle = steering_angles(front, heading);
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const LinePoint& p = front.points[i];
      ASSERT_NEAR(std::hypot(p.x_m, p.y_m), std::hypot(rear_m, wheelbase_m), 5e-3) << radius_m;
      ASSERT_NEAR(angle[i], std::atan(wheelbase_m / rear_m), 5e-3) << radius_m;
    }
  }
}

TEST(AxleLine, strays_on_a_circle_are_what_the_axles_run_within_and_without) {
  const double radius_m = 8.0;
  const DrivingLine line = circle_line(radius_m);
  const AxleStrays stray = axle_strays(line, wheelbase_m, car_headings(line, wheelbase_m));
  const double rear_m = std::sqrt(radius_m * radius_m - 0.25 * wheelbase_m * wheelbase_m);
  for (std::size_t i = 10; i + 10 < line.points.size(); ++i) {
    ASSERT_NEAR(stray.rear_m[i], radius_m - rear_m, 5e-3);
    ASSERT_NEAR(stray.front_m[i], radius_m - std::hypot(rear_m, wheelbase_m), 5e-3);
  }
}

TEST(AxleLine, slip_of_the_rear_tyres_turns_the_car_inwards_by_as_much) {
  const DrivingLine line = circle_line(50.0);
  const std::vector<double> rolling = car_headings(line, wheelbase_m);
  const std::vector<double> sliding = car_headings(line, wheelbase_m, std::vector<double>(line.points.size(), 0.05));
  for (std::size_t i = 0; i < rolling.size(); ++i) ASSERT_NEAR(sliding[i] - rolling[i], 0.05, 1e-3);
}

TEST(AxleLine, a_trailing_car_swings_in_over_half_a_wheelbase_and_leaves_a_bend_the_same_way) {
  // From a straight into a straight 0.2 rad to the left: the angle fades with exp(-2 s / wheelbase).
  std::vector<Vec2> points;
  for (int i = 0; i <= 40; ++i) points.push_back({0.25 * i, 0.0});
  for (int i = 1; i <= 40; ++i) points.push_back({10.0 + 0.25 * i * std::cos(0.2), 0.25 * i * std::sin(0.2)});
  const DrivingLine line = plain_line(points, false);
  const std::vector<double> heading = car_headings(line, wheelbase_m);
  EXPECT_NEAR(heading[40], 0.0, 0.02);
  EXPECT_NEAR(heading[60], 0.2 - 0.2 * std::exp(-2.0 * 5.0 / wheelbase_m), 2e-3);
}

TEST(SteeringLimits, the_front_axle_bounds_the_speed_and_near_the_stop_the_car_creeps) {
  const vehicle::CarParameters car = car_of("family_car.toml");
  const EnvelopeTable envelope(car);
  const double tightest_m = 1.0 / full_lock_curvature_1pm(car), half_m = 0.5 * car.body.wheelbase_m;
  for (const double radius_m : {1.02 * tightest_m, 2.0 * tightest_m, 50.0}) {
    std::vector<double> legal_mps(circle_line(radius_m).points.size(), 30.0);
    slow_down_to_steer(car, envelope, circle_line(radius_m), 4.0, legal_mps);
    // v_front^2 / R_front = 4 m/s2, and both go round in the same time.
    const double front_m = std::sqrt(radius_m * radius_m + 3.0 * half_m * half_m);
    const double expected_mps = radius_m < 1.5 * tightest_m ? 2.0 : std::sqrt(4.0 / front_m) * radius_m;
    for (std::size_t i = 20; i + 20 < legal_mps.size(); ++i)
      ASSERT_NEAR(legal_mps[i], expected_mps, 0.06 * expected_mps) << radius_m;
  }
}

TEST(CurvatureOf, a_spike_is_sharp) {
  // The circle through these points would be large: there and nearly back the same way.
  EXPECT_GT(std::abs(curvature_of({0.0, 0.0}, {1.0, 0.0}, {0.0, 0.01})), 3.0);
  EXPECT_NEAR(curvature_of({0.0, -1.0}, {1.0, 0.0}, {0.0, 1.0}), 0.5 * std::numbers::pi / std::sqrt(2.0), 1e-12);
}

TEST(DrivingLine, a_corner_tighter_than_the_car_steers_is_rounded_where_there_is_room) {
  // Round the inner lane of a stadium of 6 m: 4.25 m. A car that turns no tighter than 5 m uses the lane beside.
  const RoadMap map = map_of(make_stadium(1, 0.0, 0.0, 40.0, 4.0));
  const roadquery::RoadQuery query(map);
  const Route route{{{3, false}, {2, false}, {1, false}, {0, false}}, true, "inside", 0.0};
  const DrivingLine line = make_driving_line(query, route, {.most_curvature_1pm = 0.2});
  for (const LinePoint& p : line.points) ASSERT_LT(std::abs(p.curvature_1pm), 0.215) << p.s_m;
}

}  // namespace
}  // namespace orthodrive
