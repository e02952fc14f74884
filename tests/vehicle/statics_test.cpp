// SPDX-License-Identifier: Apache-2.0
// The car at rest, on level roads, slopes and banks.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "vehicle/cars.hpp"

namespace vehicle {
namespace {

using test::preset;

TEST(Statics, wheel_loads_are_those_of_the_moments) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    Car car(p);
    PlaneGround level(123.0);
    car.place(5.4e6, -3.2e5, 2.0, 0.0, level, 120.0);
    const State& s = car.state();
    const double weight = p.body.mass_kg * gravity_mps2;
    for (std::size_t i = 0; i < 4; ++i) {
      const double share = i < 2 ? p.body.front_share : 1.0 - p.body.front_share;
      EXPECT_NEAR(s.wheels[i].load_n, 0.5 * share * weight, 1e-3 * weight) << name;
      EXPECT_NEAR(s.wheels[i].travel_m, 0.0, 2e-4) << name;
    }
    EXPECT_NEAR(s.wheels[0].load_n + s.wheels[1].load_n + s.wheels[2].load_n + s.wheels[3].load_n, weight,
                1e-5 * weight);
    test::record(name + ": load of a front wheel at rest, N", 0.5 * p.body.front_share * weight, s.wheels[0].load_n, 1);
    EXPECT_NEAR(s.z_m, 123.0, 2e-4);
    EXPECT_NEAR(s.x_m, 5.4e6, 1e-6);
    EXPECT_NEAR(s.y_m, -3.2e5, 1e-6);
    EXPECT_NEAR(s.heading_rad, 2.0, 1e-9);
    EXPECT_NEAR(s.pitch_rad, 0.0, 2e-4);
    EXPECT_NEAR(s.roll_rad, 0.0, 1e-9);
    EXPECT_NEAR(s.cg_m[2] - s.z_m, p.body.cg_height_m, 5e-5);
  }
}

/// Brakes hold the car where it is put: nothing moves by a tenth of a millimetre once it has settled.
void expect_stands(const CarParameters& p, double heading, double gradient_x, double gradient_y, double friction) {
  Car car(p);
  PlaneGround slope(50.0, gradient_x, gradient_y, friction);
  car.place(10.0, 20.0, heading, 0.0, slope, 50.0);
  Controls brake;
  brake.brake = 0.5;
  test::drive(car, 3.0, brake, slope);
  const State before = car.state();
  test::drive(car, 60.0, brake, slope);
  const State& after = car.state();
  EXPECT_LT(std::hypot(after.x_m - before.x_m, after.y_m - before.y_m), 1e-4) << p.name << " heading " << heading;
  EXPECT_LT(std::hypot(after.x_m - 10.0, after.y_m - 20.0), 0.01);
  EXPECT_LT(std::abs(after.speed_mps) + std::abs(after.lateral_mps) + std::abs(after.rates_radps[2]), 1e-5);
  double along = 0.0, load = 0.0;
  for (const WheelState& w : after.wheels) {
    along += std::hypot(w.fx_n, w.fy_n);
    load += w.load_n;
  }
  const double steep = std::hypot(gradient_x, gradient_y), weight = p.body.mass_kg * gravity_mps2;
  EXPECT_NEAR(load, weight / std::hypot(1.0, steep), 1e-3 * weight);
  EXPECT_GE(along, weight * steep / std::hypot(1.0, steep) * 0.999);  // forces of toe-in come on top
}

TEST(Statics, stands_on_slopes_and_banks) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    for (const double heading : {0.0, 0.5 * std::numbers::pi, 2.5}) expect_stands(p, heading, 0.1, 0.0, 1.0);
    expect_stands(p, 1.0, 0.15, -0.2, 0.5);
  }
}

TEST(Statics, slope_moves_load_to_the_lower_axle) {
  const CarParameters p = preset("sports_car");
  Car car(p);
  PlaneGround slope(0.0, 0.1, 0.0);
  Controls brake;
  brake.brake = 1.0;
  car.place(0.0, 0.0, 0.0, 0.0, slope);
  test::drive(car, 5.0, brake, slope);
  const State& s = car.state();
  // Moments about the lower contact points; the c.g. as it stands.
  const double angle = std::atan(0.1), weight = p.body.mass_kg * gravity_mps2;
  const double rear_x = s.wheels[2].contact_m[0];
  const double lever = s.cg_m[0] - rear_x;
  const double front = weight * lever / (s.wheels[0].contact_m[0] - rear_x) * std::cos(angle);
  EXPECT_NEAR(s.wheels[0].load_n + s.wheels[1].load_n, front, 1e-3 * weight);
  EXPECT_LT(front, p.body.front_share * weight - 0.9 * weight * 0.1 * p.body.cg_height_m / p.body.wheelbase_m);
}

TEST(Statics, slides_where_friction_does_not_hold) {
  Car car(preset("family_car"));
  PlaneGround ice(0.0, 0.2, 0.0, 0.1);
  Controls brake;
  brake.brake = 1.0;
  car.place(0.0, 0.0, 0.0, 0.0, ice);
  test::drive(car, 5.0, brake, ice);
  EXPECT_LT(car.state().x_m, -3.0);
}

TEST(Statics, rolls_back_when_nothing_holds_it) {
  Car car(test::plain(preset("family_car")));
  PlaneGround slope(0.0, 0.05, 0.0);
  car.place(0.0, 0.0, 0.0, 0.0, slope);
  test::drive(car, 4.0, test::rolling(), slope);
  // g sin(angle) over the mass with that of the wheels' spin; drag is below a thousandth.
  const Tyre& f = car.parameters().front_tyre;
  const double turning = 2.0 * (1.1 + 1.0) / (f.radius_m * f.radius_m) / car.parameters().body.mass_kg;
  EXPECT_NEAR(car.state().speed_mps, -4.0 * gravity_mps2 * std::sin(std::atan(0.05)) / (1.0 + turning), 0.01);
}

}  // namespace
}  // namespace vehicle
