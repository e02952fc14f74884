// SPDX-License-Identifier: Apache-2.0
// Ahead: brakes, coasting, power, top speed, energy, and the size of the step.

#include <gtest/gtest.h>

#include <cmath>

#include "vehicle/car_geometry.hpp"
#include "vehicle/cars.hpp"
#include "vehicle/envelope.hpp"
#include "vehicle/magic_formula.hpp"

namespace vehicle {
namespace {

using test::preset;

double distance_to_stop(const CarParameters& p, double speed, double friction) {
  Car car(p);
  PlaneGround level(0.0, 0.0, 0.0, friction);
  car.place(0.0, 0.0, 0.0, speed, level);
  Controls c = test::rolling();
  c.brake = 1.0;
  for (int i = 0; i < 60000 && car.state().speed_mps > 0.0; ++i) car.step(1e-3, c, level);
  return car.state().x_m;
}

/// v^2 / (2 a), where a is the sliding friction of four locked wheels with the loads that a causes.
TEST(Braking, locked_wheels_slide_as_far_as_the_formula_says) {
  for (const std::string& name : test::presets) {
    CarParameters p = test::plain(preset(name));
    p.brakes.abs_slip = 0.0;
    p.brakes.front_nm = p.brakes.rear_nm = 5000.0;
    p.aero.drag_area_m2 = 0.0;
    for (const double friction : {0.3, 1.0}) {
      double a = 0.0;
      for (int n = 0; n < 50; ++n) {
        const double transfer = 0.5 * p.body.mass_kg * a * p.body.cg_height_m / p.body.wheelbase_m;
        const double front = std::max(static_load_n(p, true) + transfer, 1.0);
        const double rear = std::max(static_load_n(p, false) - transfer, 1.0);
        a = -2.0 *
            (magic_formula(p.front_tyre, front, friction, {-1.0, 0.0, 0.0}).fx_n +
             magic_formula(p.rear_tyre, rear, friction, {-1.0, 0.0, 0.0}).fx_n) /
            p.body.mass_kg;
      }
      const double expected = 30.0 * 30.0 / (2.0 * a);
      const double way = distance_to_stop(p, 30.0, friction);
      EXPECT_NEAR(way, expected, 0.015 * expected + 0.3) << name << " " << friction;
      test::record(name + (friction < 0.5 ? ": way to stop from 30 m/s, locked, friction 0.3, m"
                                          : ": way to stop from 30 m/s, locked, friction 1, m"),
                   expected, way, 2);
    }
  }
}

TEST(Braking, slip_control_comes_close_to_the_peak) {
  for (const std::string& name : test::presets) {
    const CarParameters p = preset(name);
    const Envelope limit = envelope(p, {.speed_mps = 15.0});
    const double best = 27.78 * 27.78 / (2.0 * limit.max_brake_mps2);
    const double way = distance_to_stop(p, 27.78, 1.0);
    test::record(name + ": way to stop from 100 km/h with ABS, envelope and car, m", best, way, 2);
    EXPECT_GT(way, 0.93 * best) << name;
    EXPECT_LT(way, 1.10 * best) << name;
  }
}

TEST(Braking, light_braking_is_torque_over_radius) {
  CarParameters p = test::plain(preset("family_car"));
  p.aero.drag_area_m2 = 0.0;
  Car car(p);
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, 30.0, level);
  Controls c = test::rolling();
  c.brake = 0.2;
  test::drive(car, 1.0, c, level);
  const double before = car.state().speed_mps;
  test::drive(car, 2.0, c, level);
  const double rf = 0.316 - static_load_n(p, true) / 205000.0 / 3.0,
               rr = 0.316 - static_load_n(p, false) / 205000.0 / 3.0;
  const double force = 0.4 * (p.brakes.front_nm / rf + p.brakes.rear_nm / rr);
  const double mass = p.body.mass_kg + 2.0 * (1.1 / (rf * rf) + 1.0 / (rr * rr));
  EXPECT_NEAR((before - car.state().speed_mps) / 2.0, force / mass, 0.01 * force / mass);
}

/// m v' = -(a + b v^2): v(t) = sqrt(a / b) tan(atan(v0 sqrt(b / a)) - t sqrt(a b) / m).
TEST(Coasting, loses_speed_as_drag_and_rolling_say) {
  for (const std::string& name : test::presets) {
    CarParameters p = test::plain(preset(name));
    p.differential.preload_nm = 0.0;
    p.front_tyre.rolling_resistance = p.rear_tyre.rolling_resistance = 0.012;
    Car car(p);
    PlaneGround level;
    car.place(0.0, 0.0, 0.0, 50.0, level);
    test::drive(car, 2.0, test::rolling(), level);
    const double v0 = car.state().speed_mps;
    test::drive(car, 30.0, test::rolling(), level);
    const double rf = p.front_tyre.radius_m, rr = p.rear_tyre.radius_m;
    const double mass = p.body.mass_kg + 2.0 * (p.front_tyre.wheel_inertia_kgm2 / (rf * rf) +
                                                p.rear_tyre.wheel_inertia_kgm2 / (rr * rr));
    const double a = 0.012 * p.body.mass_kg * gravity_mps2, b = 0.5 * p.aero.air_density_kgpm3 * p.aero.drag_area_m2;
    const double expected =
        std::sqrt(a / b) * std::tan(std::atan(v0 * std::sqrt(b / a)) - 30.0 * std::sqrt(a * b) / mass);
    EXPECT_NEAR(car.state().speed_mps, expected, 0.003 * v0) << name;
    test::record(name + ": speed after 30 s of coasting from 50 m/s, m/s", expected, car.state().speed_mps, 3);
  }
}

TEST(Power, at_constant_speed_is_resistance_times_speed) {
  for (const std::string& name : test::presets) {
    const CarParameters p = test::plain(preset(name));
    Car car(p);
    PlaneGround slope(0.0, 0.04, 0.0);
    car.place(0.0, 0.0, 0.0, 30.0, slope);
    Controls c;
    double held = 0.3, engine = 0.0, fuel = 0.0;
    for (int i = 0; i < 40000; ++i) {
      const double error = 30.0 - car.state().speed_mps;
      held = std::clamp(held + 1e-4 * error, 0.0, 1.0);
      c.throttle = std::clamp(held + 0.2 * error, 0.0, 1.0);
      car.step(1e-3, c, slope);
      if (i >= 30000) {
        engine += 1e-4 * car.state().powers.engine;
        fuel += 1e-4 * car.state().powers.fuel;
      }
    }
    const double force = 0.5 * p.aero.air_density_kgpm3 * p.aero.drag_area_m2 * 900.0 +
                         p.body.mass_kg * gravity_mps2 * std::sin(std::atan(0.04));
    EXPECT_NEAR(engine, force * 30.0 / p.gearbox.efficiency, 0.02 * engine) << name;
    test::record(name + ": power at 30 m/s up 4 %, kW", 0.03 * force / p.gearbox.efficiency, 1e-3 * engine, 2);
    EXPECT_GT(fuel, engine / p.engine.fuel_efficiency);
    EXPECT_LT(fuel, 2.0 * engine / p.engine.fuel_efficiency);
  }
}

struct Published {
  std::string name;
  double published_s, from_s, to_s;  // 0 to 100 km/h
  double published_kmh, least_kmh, most_kmh;
};

TEST(Power, standing_start_and_top_speed_are_plausible) {
  // Makers' numbers of the cars that the presets follow: 8.5 s, 224 km/h; 3.7 s, 308 km/h; the class about 3.2 s, 285
  // km/h.
  for (const Published& car_class : {Published{"family_car", 8.5, 7.5, 9.5, 224.0, 210.0, 230.0},
                                     Published{"sports_car", 3.7, 3.3, 4.4, 308.0, 295.0, 325.0},
                                     Published{"gt3_like", 3.2, 2.8, 3.7, 285.0, 270.0, 295.0}}) {
    const CarParameters p = preset(car_class.name);
    Car car(p);
    PlaneGround level;
    car.place(0.0, 0.0, 0.0, 0.0, level);
    Controls c;
    c.throttle = 1.0;
    double hundred = 0.0;
    for (int i = 0; i < 90000; ++i) {
      car.step(1e-3, c, level);
      if (hundred == 0.0 && car.state().speed_mps > 100.0 / 3.6) hundred = car.state().t_s;
    }
    test::record(car_class.name + ": 0 to 100 km/h, published and car, s", car_class.published_s, hundred, 2);
    test::record(car_class.name + ": top speed, published and car, km/h", car_class.published_kmh,
                 3.6 * car.state().speed_mps, 0);
    EXPECT_GT(hundred, car_class.from_s) << car_class.name;
    EXPECT_LT(hundred, car_class.to_s) << car_class.name;
    EXPECT_GT(3.6 * car.state().speed_mps, car_class.least_kmh) << car_class.name;
    EXPECT_LT(3.6 * car.state().speed_mps, car_class.most_kmh) << car_class.name;
    // Where the envelope's drive force meets the resistance.
    double v = 30.0;
    while (envelope(p, {.speed_mps = v}).max_drive_mps2 > 0.0) v += 0.05;
    EXPECT_NEAR(car.state().speed_mps, v, 0.03 * v) << car_class.name;
  }
}

/// The pedal down in the best gear: the engine also spins up the wheels and itself.
TEST(Power, accelerates_as_the_envelope_says) {
  for (const std::string& name : test::presets) {
    const CarParameters p = test::plain(preset(name));
    const double v = 45.0;
    const FullDrive drive = full_drive(p, v);
    int gear = 1;
    while (spinning_kg(p, gear) > drive.spinning_kg + 1e-9) ++gear;
    Car car(p);
    PlaneGround level(0.0, 0.0, 0.0, 1.0);
    car.place(0.0, 0.0, 0.0, v - 2.0, level);
    Controls c;
    c.throttle = 1.0, c.automatic = false, c.gear = gear;
    while (car.state().speed_mps < v - 0.2) car.step(1e-3, c, level);
    const double from_s = car.state().t_s, from_mps = car.state().speed_mps;
    while (car.state().speed_mps < v + 0.2) car.step(1e-3, c, level);
    const double reached = (car.state().speed_mps - from_mps) / (car.state().t_s - from_s);
    const double expected = envelope(p, {.speed_mps = v}).max_drive_mps2;
    EXPECT_NEAR(expected, (drive.force_n - resistance_n(p, v, gravity_mps2)) / (p.body.mass_kg + drive.spinning_kg),
                1e-4);
    EXPECT_NEAR(reached, expected, 0.03 * expected) << name;  // driving tyres slip by up to 2.5 %
    test::record(name + ": acceleration at 45 m/s in the best gear, envelope and car, m/s2", expected, reached, 2);
  }
}

/// Engine work = gain of energy + all that is lost, over a drive with everything in it.
TEST(Energy, is_kept) {
  for (const std::string& name : test::presets) {
    Car car(preset(name));
    test::ShapedGround hills([](int, double x, double y) {
      const double dx = 0.06 * std::cos(0.03 * x), dy = 0.02 * std::cos(0.05 * y);
      const double length = std::sqrt(1.0 + dx * dx + dy * dy);
      return GroundPoint{2.0 * std::sin(0.03 * x) + 0.4 * std::sin(0.05 * y),
                         {-dx / length, -dy / length, 1.0 / length}};
    });
    car.place(0.0, 0.0, 0.0, 10.0, hills);
    const double before = car.energy_j();
    double engine = 0.0, engine_out = 0.0, lost = 0.0;
    Controls c;
    for (int i = 0; i < 30000; ++i) {
      const double t = 1e-3 * i;
      c.throttle = std::fmod(t, 10.0) < 6.0 ? 0.7 : 0.0;
      c.brake = std::fmod(t, 10.0) > 7.5 ? 0.5 : 0.0;
      c.steering_rad = 0.03 * std::sin(0.8 * t);
      car.step(1e-3, c, hills);
      const Powers& p = car.state().powers;
      engine += 1e-3 * p.engine;
      engine_out += 1e-3 * std::abs(p.engine);
      lost += 1e-3 * (p.transmission + p.brakes + p.tyre_slip + p.rolling + p.suspension + p.air);
    }
    const double gained = car.energy_j() - before;
    EXPECT_NEAR(engine, gained + lost, 0.005 * engine_out) << name << " gained " << gained << " lost " << lost;
    test::record(name + ": engine work and where it went, 30 s, kJ", 1e-3 * engine, 1e-3 * (gained + lost), 1);
    EXPECT_GT(engine_out, 3e5);
  }
}

TEST(Step, half_of_it_changes_the_way_by_less_than_a_thousandth) {
  for (const std::string& name : test::presets) {
    std::array<State, 3> ends;
    const std::array<double, 3> steps = {1e-3, 5e-4, 1.25e-4};
    for (std::size_t n = 0; n < 3; ++n) {
      Car car(preset(name));
      PlaneGround level;
      car.place(0.0, 0.0, 0.0, 0.0, level);
      const int count = static_cast<int>(std::lround(20.0 / steps[n]));
      for (int i = 0; i < count; ++i) {
        const double t = i * steps[n];
        Controls c;
        c.throttle = t < 12.0 ? 1.0 : 0.0;
        c.brake = t > 13.0 ? 0.6 : 0.0;
        c.steering_rad = t > 6.0 ? 0.01 * std::sin(t - 6.0) : 0.0;
        car.step(steps[n], c, level);
      }
      ends[n] = car.state();
    }
    EXPECT_NEAR(ends[0].x_m, ends[1].x_m, 1e-3 * ends[1].x_m) << name;
    test::record(name + ": way after 20 s with steps of 0.5 and of 1 ms, m", ends[1].x_m, ends[0].x_m, 3);
    EXPECT_NEAR(ends[0].x_m, ends[2].x_m, 2e-3 * ends[1].x_m) << name;
    EXPECT_NEAR(ends[0].y_m, ends[1].y_m, 0.02 * std::abs(ends[1].y_m) + 0.2) << name;
  }
}

TEST(Controls, nonsense_counts_as_nothing) {
  Car car(preset("family_car"));
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, 10.0, level);
  Controls c;
  c.steering_rad = c.brake = std::nan("");
  c.throttle = 1e300;
  c.clutch = -5.0;
  c.gear = 99;
  c.automatic = false;
  test::drive(car, 2.0, c, level);
  EXPECT_TRUE(std::isfinite(car.state().x_m));
  EXPECT_EQ(car.state().gear, 7);
  EXPECT_NEAR(car.state().lateral_mps, 0.0, 1e-9);
}

TEST(Controls, reverse_goes_back) {
  Car car(preset("sports_car"));
  PlaneGround level;
  car.place(0.0, 0.0, 0.0, 0.0, level);
  Controls c;
  c.automatic = false;
  c.gear = -1;
  c.throttle = 0.3;
  test::drive(car, 4.0, c, level);
  EXPECT_LT(car.state().speed_mps, -1.0);
  c.throttle = 0.0;
  c.brake = 1.0;
  test::drive(car, 4.0, c, level);
  EXPECT_NEAR(car.state().speed_mps, 0.0, 1e-3);
}

}  // namespace
}  // namespace vehicle
