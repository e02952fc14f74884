// SPDX-License-Identifier: Apache-2.0
// The steady circle against linear theory; mirror images; the driver's envelope against the car itself.

#include <gtest/gtest.h>

#include <cmath>

#include "vehicle/cars.hpp"
#include "vehicle/envelope.hpp"
#include "vehicle/magic_formula.hpp"

namespace vehicle {
namespace {

using test::preset;

/// Drives with that steering and speed until nothing changes.
State steady_circle(const CarParameters& p, double steering_rad, double speed_mps, double seconds = 12.0) {
  Car car(p);
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, speed_mps, level);
  Controls c;
  double held = 0.1;
  for (int i = 0; i < static_cast<int>(seconds * 1000.0); ++i) {
    const double error = speed_mps - car.state().speed_mps;
    held = std::clamp(held + 2e-4 * error, 0.0, 1.0);
    c.throttle = std::clamp(held + 0.3 * error, 0.0, 1.0);
    c.steering_rad = steering_rad;
    car.step(1e-3, c, level);
  }
  return car.state();
}

/// delta = L / R + K a_y with K = m_f / C_f - m_r / C_r (Pacejka, sec. 1.3.2, eq. 1.50 and 1.60): C of an axle with the
/// loads at rest, levers shortened by the pneumatic trails left out by giving the tyres none.
TEST(Cornering, understeer_gradient_is_that_of_linear_theory) {
  for (const std::string& name : test::presets) {
    CarParameters p = test::plain(preset(name));
    p.front_tyre.q_dz1 = p.rear_tyre.q_dz1 = 0.0;
    p.steering.ackermann_share = 1.0;
    p.differential.preload_nm = p.differential.ramp_drive = p.differential.ramp_coast = 0.0;
    p.aero.drag_area_m2 = 0.0;  // no driving force to speak of
    const double front_kg = p.body.front_share * p.body.mass_kg, rear_kg = p.body.mass_kg - front_kg;
    const double cf = 2.0 * tyre_grip(p.front_tyre, 0.5 * front_kg * gravity_mps2, 0.0, 1.0).ky_nprad;
    const double cr = 2.0 * tyre_grip(p.rear_tyre, 0.5 * rear_kg * gravity_mps2, 0.0, 1.0).ky_nprad;
    const double expected = front_kg / cf - rear_kg / cr;
    for (const double speed : {15.0, 25.0}) {
      const double steer = 0.005;
      const State s = steady_circle(p, steer, speed);
      const double yaw = s.rates_radps[2], lateral = yaw * s.speed_mps;
      const double measured = (steer - p.body.wheelbase_m * yaw / s.speed_mps) / lateral;
      // In rad per m/s2; the scale is that of one axle.
      EXPECT_NEAR(measured, expected, 0.02 * front_kg / cf) << name << " " << speed;
      EXPECT_GT(lateral, 0.25);
      test::record(name + ": understeer gradient at " + std::to_string(static_cast<int>(speed)) + " m/s, mrad s2/m",
                   1e3 * expected, 1e3 * measured, 4);
    }
  }
}

TEST(Cornering, load_transfer_balances_the_moments) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    const State s = steady_circle(p, 0.06, 15.0);
    const double lateral = s.rates_radps[2] * s.speed_mps, track = 0.5 * (p.front.track_m + p.rear.track_m);
    EXPECT_GT(lateral, 3.0);
    double left = 0.0, right = 0.0;
    for (std::size_t i = 0; i < 4; ++i) (i % 2 == 0 ? left : right) += s.wheels[i].load_n;
    // h and a sideways shift of the c.g. by the roll, over the mean track.
    const double shift = s.roll_rad * (p.body.cg_height_m - 0.05);
    const double closed = p.body.mass_kg * (lateral * p.body.cg_height_m + gravity_mps2 * shift) / track;
    EXPECT_NEAR(0.5 * (right - left), closed, 0.03 * closed) << name;
    test::record(
        name + ": lateral load transfer in a bend of " + std::to_string(static_cast<int>(lateral)) + " m/s2, N", closed,
        0.5 * (right - left), 0);
    EXPECT_GT(s.roll_rad, 0.0);  // left side up in a left bend
    EXPECT_GT(s.acceleration_mps2[1], 0.0);
  }
}

TEST(Cornering, turns_on_the_circle_that_ackermann_says) {
  CarParameters p = test::plain(preset("family_car"));
  p.steering.ackermann_share = 1.0;
  const State s = steady_circle(p, 0.3, 2.0);
  const double radius = s.speed_mps / s.rates_radps[2];
  EXPECT_NEAR(radius, p.body.wheelbase_m / std::tan(0.3), 0.1);
}

TEST(Cornering, left_and_right_are_mirror_images) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    Car left(p), right(p);
    PlaneGround rising_left(0.0, 0.01, 0.05), rising_right(0.0, 0.01, -0.05);
    left.place(0.0, 0.0, 0.2, 20.0, rising_left);
    right.place(0.0, 0.0, -0.2, 20.0, rising_right);
    Controls c;
    for (int i = 0; i < 6000; ++i) {
      c.throttle = i < 3000 ? 0.6 : 0.0;
      c.brake = i < 4000 ? 0.0 : 0.7;
      c.steering_rad = 0.04 * std::sin(0.002 * i);
      left.step(1e-3, c, rising_left);
      c.steering_rad = -c.steering_rad;
      right.step(1e-3, c, rising_right);
    }
    const State &a = left.state(), &b = right.state();
    EXPECT_NEAR(a.x_m, b.x_m, 1e-8) << name;
    EXPECT_NEAR(a.y_m, -b.y_m, 1e-8);
    EXPECT_NEAR(a.heading_rad, -b.heading_rad, 1e-9);
    EXPECT_NEAR(a.roll_rad, -b.roll_rad, 1e-9);
    EXPECT_NEAR(a.wheels[0].load_n, b.wheels[1].load_n, 1e-4);
    EXPECT_NEAR(a.wheels[3].fy_n, -b.wheels[2].fy_n, 1e-4);
    EXPECT_GT(std::abs(a.y_m), 0.5);
  }
}

TEST(Cornering, same_calls_give_the_same_bytes) {
  const auto run = [] {
    Car car(preset("sports_car"));
    PlaneGround level;
    car.place(0.0, 0.0, 0.0, 20.0, level);
    Controls c;
    c.throttle = 0.7;
    c.steering_rad = 0.03;
    test::drive(car, 5.0, c, level);
    const Car copy = car;
    return copy.state();
  };
  const State a = run(), b = run();
  EXPECT_EQ(a.x_m, b.x_m);
  EXPECT_EQ(a.wheels[2].slip_ratio, b.wheels[2].slip_ratio);
  EXPECT_EQ(a.engine_rpm, b.engine_rpm);
}

/// Largest lateral acceleration while the steering turns slowly.
double largest_lateral(const CarParameters& p, double speed_mps) {
  Car car(p);
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, speed_mps, level);
  Controls c;
  double most = 0.0, held = 0.2;
  for (int i = 0; i < 20000 && std::abs(car.state().side_slip_rad) < 0.3; ++i) {
    const double error = speed_mps - car.state().speed_mps;
    held = std::clamp(held + 2e-4 * error, 0.0, 1.0);
    c.throttle = std::clamp(held + 0.3 * error, 0.0, 1.0);
    c.steering_rad += 1e-5 * 0.8;
    car.step(1e-3, c, level);
    if (car.state().speed_mps > 0.97 * speed_mps)
      most = std::max(most, car.state().rates_radps[2] * car.state().speed_mps);
  }
  return most;
}

TEST(EnvelopeOfTheCar, lateral_limit_is_that_of_the_car) {
  for (const auto& [name, speed] :
       {std::pair<std::string, double>{"family_car", 20.0}, {"sports_car", 30.0}, {"gt3_like", 45.0}}) {
    const CarParameters p = preset(name);
    EnvelopeQuery query;
    query.speed_mps = speed;
    const double planned = envelope(p, query).max_lateral_mps2, reached = largest_lateral(p, speed);
    EXPECT_NEAR(reached, planned, 0.08 * planned) << name;
    test::record(name + ": largest lateral acceleration, envelope and car, m/s2", planned, reached, 2);
  }
}

TEST(EnvelopeOfTheCar, behaves_with_load_friction_and_speed) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    const Envelope base = envelope(p, {.speed_mps = 30.0});
    const Envelope wet = envelope(p, {.speed_mps = 30.0, .friction = 0.6});
    EXPECT_NEAR(wet.max_lateral_mps2, 0.6 * base.max_lateral_mps2, 0.06 * base.max_lateral_mps2);
    EXPECT_LT(wet.max_brake_mps2, 0.7 * base.max_brake_mps2);
    const Envelope crest = envelope(p, {.speed_mps = 30.0, .normal_mps2 = 5.0});
    EXPECT_LT(crest.max_lateral_mps2, 0.75 * base.max_lateral_mps2);
    const Envelope bend = envelope(p, {.speed_mps = 30.0, .lateral_mps2 = 0.8 * base.max_lateral_mps2});
    EXPECT_LT(bend.max_brake_mps2, 0.75 * base.max_brake_mps2);
    EXPECT_GT(bend.max_brake_mps2, 0.2 * base.max_brake_mps2);
    const Envelope other = envelope(p, {.speed_mps = 30.0, .lateral_mps2 = -0.8 * base.max_lateral_mps2});
    EXPECT_EQ(bend.max_brake_mps2, other.max_brake_mps2);
    EXPECT_LT(envelope(p, {.speed_mps = 120.0}).max_drive_mps2, 0.0);
    EXPECT_EQ(envelope(p, {.speed_mps = 30.0, .normal_mps2 = -3.0}).max_lateral_mps2 > 1.0, name == "gt3_like");
  }
}

TEST(Envelope, leaves_each_axle_its_side_force) {
  // Under power the front axle grows light, and no more drive is left than it can stand.
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    const double most = envelope(p, {.speed_mps = 20.0}).max_lateral_mps2;
    const Envelope half = envelope(p, {.speed_mps = 20.0, .lateral_mps2 = 0.5 * most}),
                   near = envelope(p, {.speed_mps = 20.0, .lateral_mps2 = 0.97 * most}),
                   full = envelope(p, {.speed_mps = 20.0, .lateral_mps2 = most});
    EXPECT_GT(half.max_drive_mps2, near.max_drive_mps2) << name;
    EXPECT_LE(full.max_drive_mps2, 0.0) << name;  // air and rolling resistance are left
    EXPECT_GT(full.max_drive_mps2, -0.7) << name;
  }
}

}  // namespace
}  // namespace vehicle
