#include "orthodrive/drive/heave.hpp"

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

TEST(Heave, on_waves_the_body_moves_as_one_mass_on_its_springs) {
  const vehicle::CarParameters car = car_of("family_car.toml");
  double spring = 0.0, damper = 0.0;
  const double body_kg = car.body.mass_kg - 2.0 * (car.front.unsprung_mass_kg + car.rear.unsprung_mass_kg);
  for (const auto& [s, t] : {std::pair(car.front, car.front_tyre), std::pair(car.rear, car.rear_tyre)}) {
    spring += 2.0 * s.spring_npm * t.vertical_npm / (s.spring_npm + t.vertical_npm) / body_kg;
    damper += (s.bump_damping_nspm + s.rebound_damping_nspm) / body_kg;
  }
  constexpr double speed = 12.0, wave_m = 25.0, height_m = 0.02, k = 2.0 * std::numbers::pi / wave_m;
  DrivingLine line;
  for (int i = 0; i <= 400; ++i) {
    const double s = i;
    line.points.push_back(
        {.s_m = s, .x_m = s, .z_m = height_m * std::sin(k * s), .gradient = height_m * k * std::cos(k * s)});
  }
  const std::vector<double> up = heave_mps2(line, std::vector<double>(line.points.size(), speed), car);
  // Both axles, half a wheelbase before and behind, then the spring-mass-damper's answer at that frequency.
  const double w = k * speed, half = 0.5 * car.body.wheelbase_m, share = car.body.front_share;
  const std::complex<double> j(0.0, 1.0);
  const std::complex<double> road = share * std::exp(j * k * half) + (1.0 - share) * std::exp(-j * k * half);
  const std::complex<double> answer = (spring + j * w * damper) / (spring - w * w + j * w * damper);
  const double most = height_m * w * w * std::abs(road * answer);
  EXPECT_NEAR(*std::max_element(up.begin() + 200, up.end() - 5), most, 0.03 * most);
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
