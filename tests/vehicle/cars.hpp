// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cars and grounds for the tests.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "paths.hpp"
#include "vehicle/car.hpp"
#include "vehicle/read_car.hpp"

namespace vehicle::test {

inline CarParameters preset(const std::string& name) {
  return read_car(orthodrive::paths::in_source(("models/vehicles/" + name + ".toml").c_str()));
}

/// Keeps "what | asked | reached" of a check as measured_1, measured_2, ... of the running test, for
/// `tools/measure vehicle`, which reads googletest's JSON report.
inline void record(const std::string& what, double asked, double reached, int digits) {
  const auto number = [digits](double value) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%.*f", digits, value);
    return std::string(text.data());
  };
  const int count = testing::UnitTest::GetInstance()->current_test_info()->result()->test_property_count();
  testing::Test::RecordProperty("measured_" + std::to_string(count + 1),
                                what + " | " + number(asked) + " | " + number(reached));
}

inline const std::array<std::string, 3> presets = {"family_car", "sports_car", "gt3_like"};

inline Controls rolling() {
  Controls c;
  c.automatic = false;
  c.gear = 0;
  return c;
}

/// Steps of 1 ms.
inline void drive(Car& car, double seconds, const Controls& controls, Ground& ground, double dt_s = 1e-3) {
  const int steps = static_cast<int>(std::lround(seconds / dt_s));
  for (int i = 0; i < steps; ++i) car.step(dt_s, controls, ground);
}

/// A car whose wheels stand upright and straight and roll without resistance.
inline CarParameters plain(CarParameters car) {
  for (Suspension* s : {&car.front, &car.rear}) {
    s->camber_rad = s->camber_per_travel_radpm = s->toe_rad = 0.0;
  }
  for (Tyre* t : {&car.front_tyre, &car.rear_tyre}) {
    t->p_ky6 = t->p_ky7 = 0.0;
    t->rolling_resistance = t->rolling_resistance_v4 = 0.0;
  }
  car.aero.front_lift_area_m2 = car.aero.rear_lift_area_m2 = 0.0;
  return car;
}

/// Any surface without friction's details: heights and normals from functions.
class ShapedGround final : public Ground {
 public:
  using Shape = std::function<GroundPoint(int wheel, double x_m, double y_m)>;
  explicit ShapedGround(Shape shape) : shape_(std::move(shape)) {}
  GroundPoint at(int wheel, double x_m, double y_m, double /*z_guess_m*/) override { return shape_(wheel, x_m, y_m); }

 private:
  Shape shape_;
};

}  // namespace vehicle::test
