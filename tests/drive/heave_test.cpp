// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/heave.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "drive/cars.hpp"
#include "drive/roads.hpp"

namespace orthodrive {
namespace {

using namespace test;

using Complex = std::complex<double>;

/// Where the body of a quarter car goes over waves, as a share of their height: two masses, two springs with dampers.
Complex quarter_car(const vehicle::Suspension& s, const vehicle::Tyre& t, double body_kg, double w) {
  const Complex j(0.0, 1.0), strut = s.spring_npm + j * w * s.bump_damping_nspm,
                             tyre = t.vertical_npm + j * w * t.vertical_nspm;
  return strut * tyre / ((strut - body_kg * w * w) * (strut + tyre - s.unsprung_mass_kg * w * w) - strut * strut);
}

TEST(Heave, on_waves_the_body_moves_as_two_quarter_cars) {
  vehicle::CarParameters car = car_of("family_car.toml");
  for (vehicle::Suspension* s : {&car.front, &car.rear})
    s->rebound_damping_nspm = s->bump_damping_nspm, s->damper_fast_ratio = 1.0;  // so that there is a closed form
  constexpr double speed = 12.0, height_m = 0.01;
  const Complex j(0.0, 1.0);
  const double half = 0.5 * car.body.wheelbase_m, share = car.body.front_share;
  const double front_kg = 0.5 * share * car.body.mass_kg - car.front.unsprung_mass_kg,
               rear_kg = 0.5 * (1.0 - share) * car.body.mass_kg - car.rear.unsprung_mass_kg;
  for (const double wave_m : {25.0, 8.0, 3.0}) {  // to 4 a second
    const double k = 2.0 * std::numbers::pi / wave_m, w = k * speed;
    DrivingLine line;
    AxleHeights heights;
    for (int i = 0; i <= 400; ++i) line.points.push_back({.s_m = static_cast<double>(i)});
    for (double s = 0.0; s <= 400.1; s += AxleHeights::step_m) {
      heights.front_m.push_back(height_m * std::sin(k * (s + half)));
      heights.rear_m.push_back(height_m * std::sin(k * (s - half)));
    }
    const std::vector<double> up = heave_mps2(line, heights, std::vector<double>(line.points.size(), speed), car);
    const Complex body = (front_kg * quarter_car(car.front, car.front_tyre, front_kg, w) * std::exp(j * k * half) +
                          rear_kg * quarter_car(car.rear, car.rear_tyre, rear_kg, w) * std::exp(-j * k * half)) /
                         (front_kg + rear_kg);
    const double most = height_m * w * w * std::abs(body);
    EXPECT_NEAR(*std::max_element(up.begin() + 200, up.end() - 5), most, 0.03 * most) << wave_m;
  }
}

TEST(Heave, axles_stand_on_the_mean_of_their_wheels) {
  // Uphill and banked: the middle lies 1 m right of the road's middle.
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}});
  road.elevation = {{.s = 0.0, .a = 5.0, .b = 0.05}};
  road.superelevation = {{.s = 0.0, .a = 0.04}};
  const roadquery::RoadQuery query(map_of({road}));
  std::vector<Vec2> points;
  for (int i = 0; i <= 80; ++i) points.push_back({10.0 + i, -1.0});
  const DrivingLine line = line_through(query, points, false, 5.5);
  const vehicle::CarParameters car = car_of("family_car.toml");
  const AxleHeights heights = axle_heights(query, line, car);
  ASSERT_EQ(heights.front_m.size(), heights.rear_m.size());
  const double half = 0.5 * car.body.wheelbase_m, middle_m = -std::tan(0.04);
  for (std::size_t i = 0; i < 400; ++i) {
    const double x = 10.0 + AxleHeights::step_m * static_cast<double>(i);
    EXPECT_NEAR(heights.front_m[i], 5.0 + 0.05 * (x + half) + middle_m, 1e-4);
    EXPECT_NEAR(heights.rear_m[i], 5.0 + 0.05 * (x - half) + middle_m, 1e-4);
  }
}

TEST(Heave, a_driver_slows_for_a_ramp_that_is_shorter_than_a_metre) {
  // 5 cm up within half a metre, which no point of the line sees.
  Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 200.0, Line{}});
  road.elevation = {{0.0, 0.0, 0.0, 0.0, 0.0}, {100.25, 0.0, 0.1, 0.0, 0.0}, {100.75, 0.05, 0.0, 0.0, 0.0}};
  road.speed_limit_mps = 13.9;
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_LT(lap.max_vertical_mps2, 5.0);
  EXPECT_GT(lap.max_vertical_mps2, 1.5);
}

TEST(Heave, a_driver_slows_for_a_ramp_so_that_the_body_stays_within_5_mps2) {
  // Up a ramp of 8 % within a metre, at 50 km/h allowed.
  Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 200.0, Line{}});
  road.elevation = {{0.0, 0.0, 0.0, 0.0, 0.0}, {100.0, 0.0, 0.0, 0.04, 0.0}, {101.0, 0.04, 0.08, 0.0, 0.0}};
  road.speed_limit_mps = 13.9;
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_LT(lap.max_vertical_mps2, 5.0);
  EXPECT_GT(lap.max_vertical_mps2, 1.0);
  EXPECT_GT(lap.max_speed_mps, 13.0);
}

}  // namespace
}  // namespace orthodrive
