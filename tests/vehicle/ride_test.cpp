// SPDX-License-Identifier: Apache-2.0
// Heave, pitch and wheel hop against the two-mass model solved in closed form.

#include <gtest/gtest.h>

#include <cmath>

#include "vehicle/car_geometry.hpp"
#include "vehicle/cars.hpp"

namespace vehicle {
namespace {

using test::preset;

/// Body mass on a spring on a wheel mass on the tyre's spring, undamped, from rest, ground raised by `step` at t = 0.
struct TwoMasses {
  double body_kg, wheel_kg, spring_npm, tyre_npm;

  /// Squares of the circular frequencies: roots of m M w^4 - (m k + M (k + c)) w^2 + k c = 0 (M wheel, c tyre).
  [[nodiscard]] std::array<double, 2> squares() const {
    const double a = body_kg * wheel_kg;
    const double b = body_kg * (spring_npm + tyre_npm) + wheel_kg * spring_npm;
    const double c = spring_npm * tyre_npm, root = std::sqrt(b * b - 4.0 * a * c);
    return {(b - root) / (2.0 * a), (b + root) / (2.0 * a)};
  }
  /// Heights of body and wheel over where they were.
  [[nodiscard]] std::array<double, 2> heights(double step, double t) const {
    const auto w2 = squares();
    std::array<double, 2> z = {step, step};
    // Modes (1, r) with r = 1 - m w^2 / k; both masses start at -step from where they end.
    const double r0 = 1.0 - body_kg * w2[0] / spring_npm, r1 = 1.0 - body_kg * w2[1] / spring_npm;
    const double q1 = -step * (1.0 - r0) / (r1 - r0), q0 = -step - q1;
    for (int mode = 0; mode < 2; ++mode) {
      const double q = (mode == 0 ? q0 : q1) * std::cos(std::sqrt(w2[mode]) * t);
      z[0] += q;
      z[1] += q * (mode == 0 ? r0 : r1);
    }
    return z;
  }
};

/// Both axles alike, no dampers, nothing but vertical forces.
CarParameters undamped() {
  CarParameters p = test::plain(preset("family_car"));
  p.body.front_share = 0.5;
  p.rear = p.front;
  p.rear_tyre = p.front_tyre;
  for (Suspension* s : {&p.front, &p.rear}) {
    s->bump_damping_nspm = s->rebound_damping_nspm = 0.0;
    s->roll_centre_m = s->brake_support_rad = s->drive_support_rad = 0.0;
  }
  p.front_tyre.vertical_nspm = p.rear_tyre.vertical_nspm = 0.0;
  return p;
}

TEST(Ride, heave_and_wheel_hop_are_those_of_two_masses) {
  const CarParameters p = undamped();
  Car car(p);
  double height = 0.0;
  test::ShapedGround ground([&](int, double, double) { return GroundPoint{height}; });
  car.place(0.0, 0.0, 0.0, 0.0, ground);
  const CarGeometry g = car_geometry(p);
  const TwoMasses model{0.25 * g.body.mass_kg, p.front.unsprung_mass_kg, p.front.spring_npm, p.front_tyre.vertical_npm};
  const double hub = car.state().wheels[0].hub_m[2], body = hub - car.state().wheels[0].travel_m;
  height = 0.01;
  double worst = 0.0;
  for (int i = 1; i <= 3000; ++i) {  // over three swings of the body, thirty of the wheel
    car.step(1e-3, test::rolling(), ground);
    const auto z = model.heights(0.01, 1e-3 * i);
    const WheelState& w = car.state().wheels[0];
    worst = std::max({worst, std::abs(w.hub_m[2] - hub - z[1]), std::abs(w.hub_m[2] - w.travel_m - body - z[0])});
  }
  test::record("heave and wheel hop after a step of 10 mm, undamped, 3 s: largest difference, mm", 0.0, 1e3 * worst, 2);
  EXPECT_LT(worst, 0.05 * 0.01);
  EXPECT_GT(std::abs(model.heights(0.01, 0.4)[0]), 0.015);  // it swings
}

TEST(Ride, pitch_is_that_of_two_masses) {
  CarParameters p = undamped();
  // The c.g. low, so that the tyres' way ahead and back in pitch does not matter.
  p.body.cg_height_m = 0.3;
  Car car(p);
  double height = 0.0;
  test::ShapedGround ground([&](int wheel, double, double) { return GroundPoint{wheel < 2 ? height : -height}; });
  car.place(0.0, 0.0, 0.0, 0.0, ground);
  const CarGeometry g = car_geometry(p);
  const double arm = 0.5 * p.body.wheelbase_m;
  const TwoMasses model{0.25 * g.body.inertia.yy / (arm * arm), p.front.unsprung_mass_kg, p.front.spring_npm,
                        p.front_tyre.vertical_npm};
  height = 0.005;
  const double pitch = car.state().pitch_rad;
  double worst = 0.0;
  for (int i = 1; i <= 2000; ++i) {
    car.step(1e-3, test::rolling(), ground);
    worst = std::max(worst, std::abs(-arm * (car.state().pitch_rad - pitch) - model.heights(0.005, 1e-3 * i)[0]));
  }
  test::record("pitch after a step of 5 mm, undamped, 2 s: largest difference at the axle, mm", 0.0, 1e3 * worst, 2);
  EXPECT_LT(worst, 0.08 * 0.005);
}

TEST(Ride, dampers_end_it) {
  Car car(preset("sports_car"));
  double height = 0.0;
  test::ShapedGround ground([&](int, double, double) { return GroundPoint{height}; });
  car.place(0.0, 0.0, 0.0, 0.0, ground);
  height = 0.02;
  test::drive(car, 3.0, test::rolling(), ground);
  EXPECT_NEAR(car.state().z_m, 0.02, 5e-4);
  EXPECT_LT(std::abs(car.state().vertical_mps), 1e-3);
}

TEST(Ride, a_kerb_throws_no_nonsense) {
  for (const std::string& name : test::presets) {
    for (const double step : {0.05, 0.15, -0.3, 1000.0}) {
      Car car(preset(name));
      test::ShapedGround ground([&](int wheel, double x, double) {
        GroundPoint point{x > 20.0 && wheel % 2 == 0 ? step : 0.0};
        point.on_road = x <= 20.0;
        return point;
      });
      car.place(0.0, 0.0, 0.0, 20.0, ground);
      Controls c;
      c.throttle = 0.2;
      for (int i = 0; i < 3000; ++i) {
        car.step(1e-3, c, ground);
        const State& s = car.state();
        ASSERT_TRUE(std::isfinite(s.x_m + s.y_m + s.z_m + s.roll_rad + s.speed_mps)) << name << " " << step;
        ASSERT_LT(std::abs(s.z_m), 3000.0);
      }
      EXPECT_FALSE(car.state().wheels[0].on_road);
      if (std::abs(step) < 0.1) {
        EXPECT_GT(car.state().speed_mps, 15.0);
        EXPECT_LT(std::abs(car.state().roll_rad), 0.1);
      }
    }
  }
}

TEST(Ride, no_ground_means_free_fall) {
  Car car(preset("family_car"));
  bool gone = false;
  test::ShapedGround ground([&](int, double, double) { return GroundPoint{gone ? std::nan("") : 0.0}; });
  car.place(0.0, 0.0, 0.0, 0.0, ground);
  gone = true;
  test::drive(car, 1.0, {}, ground);
  EXPECT_NEAR(car.state().cg_m[2] - car.parameters().body.cg_height_m, -0.5 * gravity_mps2,
              0.02);  // the wheels fall deeper
  EXPECT_EQ(car.state().wheels[3].load_n, 0.0);
}

}  // namespace
}  // namespace vehicle
