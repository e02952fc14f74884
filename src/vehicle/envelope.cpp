// SPDX-License-Identifier: Apache-2.0
#include "vehicle/envelope.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "vehicle/car_geometry.hpp"
#include "vehicle/engine.hpp"
#include "vehicle/gear_shift.hpp"
#include "vehicle/magic_formula.hpp"

namespace vehicle {
namespace {

constexpr double least_wheel_load_n = 1.0;
constexpr double reference_speed_mps = 16.67;
constexpr int halvings = 6, most_rounds = 60;
constexpr double most_mps2 = 100.0, solved_mps2 = 1e-7;

/// Up to where something is left over, from 0 to 100: some halvings, then false position that never keeps one end
/// twice (Illinois; Dowell and Jarratt, BIT 11, 1971), which takes a third of the rounds of halving alone.
template <typename Function>
double last_with(const Function& left_over) {
  double low = 0.0, high = most_mps2, at_low = 0.0, at_high = 0.0;
  for (int n = 0; n < halvings; ++n) {
    const double middle = 0.5 * (low + high), value = left_over(middle);
    (value >= 0.0 ? low : high) = middle;
    (value >= 0.0 ? at_low : at_high) = value;
  }
  if (low <= 0.0) at_low = left_over(low);
  if (high >= most_mps2 || at_low <= 0.0) return low;
  for (int n = 0, side = 0; n < most_rounds && high - low > solved_mps2; ++n) {
    const double middle = (low * at_high - high * at_low) / (at_high - at_low), value = left_over(middle);
    if (std::abs(value) < solved_mps2) return middle;
    if (value > 0.0) {
      low = middle, at_low = value;
      if (side > 0) at_high *= 0.5;
      side = 1;
    } else {
      high = middle, at_high = value;
      if (side < 0) at_low *= 0.5;
      side = -1;
    }
  }
  return low;
}

double rolling_radius_m(const Tyre& tyre, double load_n) { return tyre.radius_m - load_n / tyre.vertical_npm / 3.0; }

/// Mean of the driven wheels.
double driven_radius_m(const CarParameters& car) {
  const double front = car.differential.front_share;
  return front * rolling_radius_m(car.front_tyre, static_load_n(car, true)) +
         (1.0 - front) * rolling_radius_m(car.rear_tyre, static_load_n(car, false));
}

/// A steady state: accelerations in the road plane and what follows for the wheels.
class SteadyState {
 public:
  SteadyState(const CarParameters& car, const EnvelopeQuery& query) : car_(car), query_(query) {
    const Aero& a = car.aero;
    const double pressure = 0.5 * a.air_density_kgpm3 * query.speed_mps * query.speed_mps;
    const double weight_n = car.body.mass_kg * std::max(query.normal_mps2, 0.0);
    axle_n_ = {car.body.front_share * weight_n - pressure * a.front_lift_area_m2,
               (1.0 - car.body.front_share) * weight_n - pressure * a.rear_lift_area_m2};
    drag_n_ = pressure * a.drag_area_m2;
    drag_arm_n_ = drag_n_ * car.body.cg_height_m / car.body.wheelbase_m;
    for (std::size_t i = 0; i < 2; ++i) {
      const Suspension& s = i == 0 ? car.front : car.rear;
      const Tyre& t = i == 0 ? car.front_tyre : car.rear_tyre;
      // Spring and bar in series with the tyre.
      const double at_wheel = s.spring_npm + 2.0 * s.anti_roll_npm;
      roll_stiffness_[i] = 0.5 * s.track_m * s.track_m * at_wheel * t.vertical_npm / (at_wheel + t.vertical_npm);
    }
  }

  /// Loads of the wheels. The tyres give along_mps2 and lateral_mps2 times the mass.
  [[nodiscard]] std::array<double, 4> loads(double along_mps2, double lateral_mps2) const {
    const Body& b = car_.body;
    const double mass = b.mass_kg;
    // Pitch: the sum of the tyres' forces acts at the road, drag too (its lift is in the lift areas).
    const double pitch_n = mass * along_mps2 * b.cg_height_m / b.wheelbase_m - drag_arm_n_;
    const std::array<double, 2> axle = {axle_n_[0] - pitch_n, axle_n_[1] + pitch_n};
    const std::array<double, 2> share = {b.front_share, 1.0 - b.front_share};
    const double axis_m = share[0] * car_.front.roll_centre_m + share[1] * car_.rear.roll_centre_m;
    const double roll_nm = mass * lateral_mps2 * (b.cg_height_m - axis_m);
    std::array<double, 4> load{};
    for (std::size_t i = 0; i < 2; ++i) {
      const Suspension& s = i == 0 ? car_.front : car_.rear;
      const double through_springs = roll_nm * roll_stiffness_[i] / (roll_stiffness_[0] + roll_stiffness_[1]);
      const double through_links = mass * share[i] * lateral_mps2 * s.roll_centre_m;
      const double transfer = (through_springs + through_links) / s.track_m;
      const double all = std::max(axle[i], 0.0), half = 0.5 * all;
      load[2 * i] = std::clamp(half - transfer, 0.0, all);
      load[2 * i + 1] = all - load[2 * i];
    }
    return load;
  }

  [[nodiscard]] TyreGrip grip(std::size_t wheel, double load_n) const {
    return tyre_grip(tyre(wheel), std::max(load_n, least_wheel_load_n), 0.0, query_.friction);
  }
  [[nodiscard]] const Tyre& tyre(std::size_t wheel) const { return wheel < 2 ? car_.front_tyre : car_.rear_tyre; }

  /// Share of the lateral grip of an axle that the lateral acceleration takes; over 1: too much.
  [[nodiscard]] double lateral_use(std::size_t axle, double along_mps2, double lateral_mps2) const {
    const auto load = loads(along_mps2, lateral_mps2);
    const double share = axle == 0 ? car_.body.front_share : 1.0 - car_.body.front_share;
    const double able = grip(2 * axle, load[2 * axle]).dy_n + grip(2 * axle + 1, load[2 * axle + 1]).dy_n;
    return share * car_.body.mass_kg * std::abs(lateral_mps2) / std::max(able, least_wheel_load_n);
  }

  /// What the friction ellipse leaves to each wheel beside its share of the lateral acceleration, N.
  [[nodiscard]] std::array<double, 4> grip_left_n(double along_mps2, double lateral_mps2) const {
    const auto load = loads(along_mps2, lateral_mps2);
    std::array<double, 4> able{};
    for (std::size_t axle = 0; axle < 2; ++axle) {
      const double use = lateral_use(axle, along_mps2, lateral_mps2);
      const double left = std::sqrt(std::max(1.0 - use * use, 0.0));
      for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i) able[i] = left * grip(i, load[i]).dx_n;
    }
    return able;
  }

  /// Forces of the axles that drive: no more than their share of the engine's force.
  [[nodiscard]] std::array<double, 2> driving_n(double along_mps2, double lateral_mps2, double engine_n) const {
    const auto able = grip_left_n(along_mps2, lateral_mps2);
    const double front = car_.differential.front_share;
    return {std::min(able[0] + able[1], front * engine_n), std::min(able[2] + able[3], (1.0 - front) * engine_n)};
  }

  /// Forces of the brakes at full pedal.
  [[nodiscard]] std::array<double, 4> brakes_n(double along_mps2, double lateral_mps2) const {
    auto force = loads(along_mps2, lateral_mps2);
    for (std::size_t i = 0; i < 4; ++i)
      force[i] = (i < 2 ? car_.brakes.front_nm : car_.brakes.rear_nm) / rolling_radius_m(tyre(i), force[i]);
    return force;
  }

  /// Forces of the wheels that brake.
  [[nodiscard]] std::array<double, 4> braking_n(double along_mps2, double lateral_mps2) const {
    auto able = grip_left_n(-along_mps2, lateral_mps2);
    const auto brakes = brakes_n(-along_mps2, lateral_mps2);
    for (std::size_t i = 0; i < 4; ++i) able[i] = std::min(able[i], brakes[i]);
    return able;
  }

  [[nodiscard]] double rolling_n(double along_mps2, double lateral_mps2) const {
    const auto load = loads(along_mps2, lateral_mps2);
    const double relative = query_.speed_mps / reference_speed_mps;
    const double fourth = relative * relative * relative * relative;
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += load[i] * (tyre(i).rolling_resistance + tyre(i).rolling_resistance_v4 * fourth);
    }
    return sum;
  }
  [[nodiscard]] double drag_n() const { return drag_n_; }

 private:
  const CarParameters& car_;
  const EnvelopeQuery& query_;
  std::array<double, 2> axle_n_{}, roll_stiffness_{};
  double drag_n_ = 0.0, drag_arm_n_ = 0.0;
};

double max_lateral_mps2(const SteadyState& steady) {
  return last_with([&](double lateral) {
    return 1.0 - std::max(steady.lateral_use(0, 0.0, lateral), steady.lateral_use(1, 0.0, lateral));
  });
}

template <std::size_t count>
double sum(const std::array<double, count>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// Up to which acceleration ahead (sign 1) or backwards (sign -1) both axles hold their side forces.
double holding_mps2(const SteadyState& steady, double sign, double lateral_mps2) {
  return last_with([&](double along) {
    return 1.0 - std::max(steady.lateral_use(0, sign * along, lateral_mps2),
                          steady.lateral_use(1, sign * along, lateral_mps2));
  });
}

/// The acceleration at which these forces (of an acceleration) give it to the mass: loads depend on what they limit.
template <typename Forces>
double agreeing(double mass_kg, const Forces& forces) {
  return last_with([&](double along) { return sum(forces(along)) / mass_kg - along; });
}

}  // namespace

double resistance_n(const CarParameters& car, double speed_mps, double normal_mps2) {
  const EnvelopeQuery query{speed_mps, normal_mps2, 0.0, 1.0};
  const SteadyState steady(car, query);
  return steady.drag_n() + steady.rolling_n(0.0, 0.0);
}

FullDrive full_drive(const CarParameters& car, double speed_mps) {
  const double radius_m = driven_radius_m(car);
  FullDrive most;
  for (int gear = 1; gear <= static_cast<int>(car.gearbox.ratios.size()); ++gear) {
    const double ratio = gear_ratio(car, gear);
    // Below the launch speed of first gear the clutch slips.
    const double turned = std::abs(speed_mps) / radius_m * ratio * rpm_per_radps;
    const bool slips = gear == 1 && turned < car.gearbox.launch_rpm;
    const double rpm = slips ? car.gearbox.launch_rpm : turned;
    if (rpm > car.engine.limit_rpm || rpm < car.engine.idle_rpm) continue;
    const double force_n = crankshaft_nm(car.engine, rpm, 1.0) * ratio * car.gearbox.efficiency / radius_m;
    if (force_n > most.force_n) most = {force_n, spinning_kg(car, slips ? 0 : gear)};
  }
  return most;
}

double spinning_kg(const CarParameters& car, int gear) {
  const double front_m = rolling_radius_m(car.front_tyre, static_load_n(car, true)),
               rear_m = rolling_radius_m(car.rear_tyre, static_load_n(car, false));
  const double turns_1pm = gear_ratio(car, gear) / driven_radius_m(car);
  return 2.0 * car.front_tyre.wheel_inertia_kgm2 / (front_m * front_m) +
         2.0 * car.rear_tyre.wheel_inertia_kgm2 / (rear_m * rear_m) +
         car.gearbox.efficiency * car.engine.inertia_kgm2 * turns_1pm * turns_1pm;
}

Envelope envelope(const CarParameters& car, const EnvelopeQuery& query) {
  const SteadyState steady(car, query);
  const double lateral = std::abs(query.lateral_mps2), mass = car.body.mass_kg;
  const FullDrive engine = full_drive(car, query.speed_mps);
  const auto resisting_mps2 = [&](double along) { return (steady.drag_n() + steady.rolling_n(along, lateral)) / mass; };
  const double drive = std::min(holding_mps2(steady, 1.0, lateral), agreeing(mass, [&](double along) {
                                  const double faster = along - resisting_mps2(along);
                                  return steady.driving_n(along, lateral, engine.force_n - engine.spinning_kg * faster);
                                }));
  const double brake = std::min(holding_mps2(steady, -1.0, lateral),
                                agreeing(mass, [&](double along) { return steady.braking_n(along, lateral); }));
  return {max_lateral_mps2(steady), drive - resisting_mps2(drive), brake + resisting_mps2(-brake)};
}

Grip grip_of(const CarParameters& car, const EnvelopeQuery& query) {
  constexpr double no_limit_n = 1e9;
  const SteadyState steady(car, query);
  const double lateral = std::abs(query.lateral_mps2), mass = car.body.mass_kg;
  Grip grip{.max_lateral_mps2 = max_lateral_mps2(steady)};
  grip.holding_drive_mps2 = holding_mps2(steady, 1.0, lateral);
  grip.holding_brake_mps2 = holding_mps2(steady, -1.0, lateral);
  const double braking = agreeing(mass, [&](double along) { return steady.braking_n(along, lateral); });
  grip.braking_n = steady.grip_left_n(-braking, lateral);
  grip.brakes_n = steady.brakes_n(-braking, lateral);
  grip.driving_mps2 = agreeing(mass, [&](double along) { return steady.driving_n(along, lateral, no_limit_n); });
  const auto of_axles = [](const std::array<double, 4>& wheels) {
    return std::array{wheels[0] + wheels[1], wheels[2] + wheels[3]};
  };
  grip.rolling_n = of_axles(steady.grip_left_n(0.0, lateral));
  grip.driving_n = of_axles(steady.grip_left_n(grip.driving_mps2, lateral));
  return grip;
}

}  // namespace vehicle
