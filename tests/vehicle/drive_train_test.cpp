// SPDX-License-Identifier: Apache-2.0
// Differentials, all-wheel drive, gears, idle.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "vehicle/cars.hpp"

namespace vehicle {
namespace {

using test::preset;

/// Speed after a standing start of 4 s with the left wheels on ice.
double start_on_split_friction(const CarParameters& p) {
  Car car(p);
  test::ShapedGround ground([](int wheel, double, double) {
    GroundPoint point;
    point.friction = wheel % 2 == 0 ? 0.1 : 1.0;
    return point;
  });
  car.place(0.0, 0.0, 0.0, 0.0, ground);
  Controls c;
  c.throttle = 0.4;
  for (int i = 0; i < 4000; ++i) {
    c.steering_rad = std::clamp(-2.0 * car.state().heading_rad - 0.2 * car.state().y_m, -0.3, 0.3);
    car.step(1e-3, c, ground);
  }
  return car.state().speed_mps;
}

TEST(Differential, locking_brings_a_car_off_the_ice) {
  CarParameters p = preset("family_car");  // front wheels pull it straight
  p.brakes.traction_slip = 0.0;
  p.differential.preload_nm = p.differential.ramp_drive = p.differential.ramp_coast = 0.0;
  const double open = start_on_split_friction(p);
  p.differential.ramp_drive = 0.5;
  p.differential.preload_nm = 200.0;
  const double locking = start_on_split_friction(p);
  // Open: both wheels push as little as the one on ice, at most 0.1 of the load that acceleration leaves them.
  EXPECT_LT(open, 4.0 * gravity_mps2 * 0.1 * 1.4);
  EXPECT_GT(locking, 1.5 * open);
}

TEST(Differential, splits_the_torque_between_the_axles) {
  CarParameters p = preset("sports_car");
  p.differential = {0.4, 0.0, 0.0, 0.0, 0.0};
  Car car(p);
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, 20.0, level);
  Controls c;
  c.throttle = 0.5;
  c.automatic = false;
  c.gear = 3;
  test::drive(car, 2.0, c, level);
  const auto& w = car.state().wheels;
  const double front = w[0].drive_nm + w[1].drive_nm, rear = w[2].drive_nm + w[3].drive_nm;
  EXPECT_GT(front, 100.0);
  EXPECT_NEAR(front / (front + rear), 0.4, 1e-6);
}

TEST(Differential, all_wheels_start_faster_than_two_on_wet_road) {
  const auto start = [](double front_share) {
    CarParameters p = preset("sports_car");
    p.differential.front_share = front_share;
    p.differential.centre_preload_nm = 100.0;
    Car car(p);
    PlaneGround wet(0.0, 0.0, 0.0, 0.4);
    car.place(0.0, 0.0, 0.0, 0.0, wet);
    Controls c;
    c.throttle = 1.0;
    test::drive(car, 4.0, c, wet);
    return car.state().speed_mps;
  };
  EXPECT_GT(start(0.35), 1.15 * start(0.0));
}

TEST(Gears, go_up_one_by_one_and_never_overrev) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    Car car(p);
    PlaneGround level;
    car.place(0.0, 0.0, 0.0, 0.0, level);
    Controls c;
    c.throttle = 1.0;
    int gear = 1;
    for (int i = 0; i < 30000; ++i) {
      car.step(1e-3, c, level);
      const State& s = car.state();
      ASSERT_GE(s.gear, gear) << name << " at " << s.t_s;
      ASSERT_LE(s.gear, gear + 1);
      ASSERT_LT(s.engine_rpm, 1.02 * p.engine.limit_rpm);
      gear = s.gear;
    }
    EXPECT_GE(gear, 5);
  }
}

/// How far the acceleration goes beyond that before the shift and that in the new gear, while gears change.
double push_of_shifts(const std::string& name, double from_mps, double throttle, double brake) {
  Car car(preset(name));
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, from_mps, level);
  Controls c;
  c.throttle = throttle, c.brake = brake;
  double push = -1e9, before = 0.0, now = 0.0;
  for (int i = 0; i < 12000 && car.state().speed_mps < 60.0; ++i) {
    before = now;
    car.step(1e-3, c, level);
    now = car.state().acceleration_mps2[0];
    if (!car.state().shifting || i < 1500) continue;
    double most = before;
    for (int k = 0; k < 500; ++k) {
      car.step(1e-3, c, level);
      now = car.state().acceleration_mps2[0];
      most = std::max(most, now);
    }
    push = std::max(push, most - std::max(before, now));
  }
  return push;
}

TEST(Gears, a_shift_does_not_push_the_car) {
  for (const std::string& name : test::presets) {
    for (const double throttle : {0.2, 0.5, 1.0}) EXPECT_LT(push_of_shifts(name, 0.0, throttle, 0.0), 0.6) << name;
    // On the overrun the open clutch takes the drag of the engine away.
    EXPECT_LT(push_of_shifts(name, 45.0, 0.0, 0.15), 0.9) << name;
  }
}

TEST(Gears, a_stop_in_gear_does_not_stall_and_idle_does_not_creep) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    Car car(p);
    PlaneGround level;
    car.place(0.0, 0.0, 0.0, 30.0, level);
    Controls c;
    c.brake = 0.6;
    double least = 1e9;
    for (int i = 0; i < 8000; ++i) {
      car.step(1e-3, c, level);
      least = std::min(least, car.state().engine_rpm);
    }
    EXPECT_GT(least, 0.8 * p.engine.idle_rpm) << name;
    EXPECT_EQ(car.state().gear, 1);
    c.brake = 0.0;
    const double stood = car.state().x_m;
    test::drive(car, 5.0, c, level);
    EXPECT_NEAR(car.state().x_m, stood, 0.05) << name;
    EXPECT_NEAR(car.state().engine_rpm, p.engine.idle_rpm, 0.05 * p.engine.idle_rpm);
    EXPECT_GT(car.state().powers.fuel, 0.0);
  }
}

}  // namespace
}  // namespace vehicle
