// SPDX-License-Identifier: Apache-2.0
#include "vehicle/drive_train.hpp"

#include <algorithm>
#include <cmath>

#include "vehicle/engine.hpp"

namespace vehicle {
namespace {

constexpr int most_sweeps = 8;
constexpr double settled_radps = 1e-9;    // a sweep that changes no speed by more is the last
constexpr double throttle_lag_s = 0.03;   // of the air in the manifold
constexpr double control_from_mps = 3.0;  // slip controllers take at least this speed as reference
constexpr double abs_least_mps = 1.5;     // below, brakes may lock
constexpr double abs_gain_1ps = 12.0, traction_gain_1ps = 4.0;
constexpr double release_limit = 4.0;  // fastest release, in units of the gain
constexpr double traction_at_once =
    0.3;  // share of the throttle that goes at twice the target, before the integral acts

double wheel_slip(const WheelLoad& wheel) {
  const double way = wheel.speed_mps < 0.0 ? -1.0 : 1.0;
  return way * wheel.slip_mps / std::max(std::abs(wheel.speed_mps), control_from_mps);
}

/// Integrating slip controller: opens while the slip is below the target, closes quickly above it.
double controlled(double share, double slip, double target, double gain_1ps, double dt_s, double least) {
  return std::clamp(share + dt_s * gain_1ps * std::max((target - slip) / target, -release_limit), least, 1.0);
}

}  // namespace

/// One step of dry friction: speeds as they change, limits of the impulses, responses. Limits are N m s.
struct DriveTrain::Sweep {
  std::array<double, 4> spin{}, inverse_inertia{}, hold_limit{};
  std::array<double, 4> speed_share{};  ///< of a wheel in the speed of the gearbox' input
  double engine = 0.0, inverse_engine = 0.0, clutch_response = 0.0, efficiency = 1.0;
  double clutch_limit = 0.0, preload = 0.0, centre_limit = 0.0;
  double ramp_drive = 0.0, ramp_coast = 0.0;  ///< of the impulse of an axle
  double front_share = 0.0, ratio = 0.0;

  [[nodiscard]] double through_clutch(double impulse) const {
    return impulse >= 0.0 ? efficiency * impulse : impulse / efficiency;
  }
  [[nodiscard]] double axle_limit(double clutch_impulse, bool front) const {
    const double axle = std::abs(ratio) * through_clutch(clutch_impulse) * (front ? front_share : 1.0 - front_share);
    return preload + std::abs(axle) * (clutch_impulse >= 0.0 ? ramp_drive : ramp_coast);
  }
  void push_engine(double change_at_wheels, double change) {
    engine -= change * inverse_engine;
    for (std::size_t i = 0; i < 4; ++i) spin[i] += change_at_wheels * speed_share[i] * inverse_inertia[i];
  }
  void clutch(double& impulse) {
    if (clutch_limit <= 0.0) return;
    double slip = engine;
    for (std::size_t i = 0; i < 4; ++i) slip -= speed_share[i] * spin[i];
    const double before = impulse;
    impulse = std::clamp(before + slip / clutch_response, -clutch_limit, clutch_limit);
    push_engine(through_clutch(impulse) - through_clutch(before), impulse - before);
  }
  void start_lock(std::size_t left, double limit, double& impulse) {
    impulse = std::clamp(impulse, -limit, limit);
    spin[left] -= impulse * inverse_inertia[left];
    spin[left + 1] += impulse * inverse_inertia[left + 1];
  }
  void lock(std::size_t left, double limit, double& impulse) {
    const double before = impulse, response = inverse_inertia[left] + inverse_inertia[left + 1];
    impulse = std::clamp(before + (spin[left] - spin[left + 1]) / response, -limit, limit);
    spin[left] -= (impulse - before) * inverse_inertia[left];
    spin[left + 1] += (impulse - before) * inverse_inertia[left + 1];
  }
  /// Between the axles.
  void centre(bool first, double& impulse) {
    const double before = first ? 0.0 : impulse;
    const double response = 0.25 * (inverse_inertia[0] + inverse_inertia[1] + inverse_inertia[2] + inverse_inertia[3]);
    const double difference = 0.5 * (spin[0] + spin[1] - spin[2] - spin[3]);
    impulse = std::clamp(before + difference / response, -centre_limit, centre_limit);
    for (std::size_t i = 0; i < 4; ++i) spin[i] -= (i < 2 ? 0.5 : -0.5) * (impulse - before) * inverse_inertia[i];
  }
};

DriveTrain::DriveTrain(const CarParameters& car) {
  const double front = 0.5 * car.differential.front_share;
  share_ = {front, front, 0.5 - front, 0.5 - front};
  for (std::size_t i = 0; i < 4; ++i) {
    inertia_[i] = (i < 2 ? car.front_tyre : car.rear_tyre).wheel_inertia_kgm2;
  }
  engine_radps_ = car.engine.idle_rpm / rpm_per_radps;
}

void DriveTrain::place(const CarParameters& car, const std::array<double, 4>& spin_radps) {
  double mean = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    wheels_[i] = WheelSpin{spin_radps[i]};
    mean += share_[i] * spin_radps[i];
  }
  const int last = static_cast<int>(car.gearbox.ratios.size());
  int gear = 1;
  const double calm_rpm = 0.5 * (car.gearbox.up_calm_rpm + car.gearbox.up_rpm);
  while (gear < last && mean * gear_ratio(car, gear) * rpm_per_radps > calm_rpm) ++gear;
  const double idle = car.engine.idle_rpm / rpm_per_radps, turned = mean * gear_ratio(car, gear);
  gears_ = GearShift();
  gears_.set(gear, turned > 1.2 * idle);
  engine_radps_ = turned > 1.2 * idle ? turned : idle;
  engine_nm_ = throttle_ = 0.0;
  abs_ = {1.0, 1.0, 1.0, 1.0};
  traction_ = traction_held_ = 1.0;
  impulse_ = Friction();
}

double DriveTrain::engine_torque(const CarParameters& car, double dt_s, double throttle) const {
  const double rpm = engine_radps_ * rpm_per_radps;
  const bool gear_is_in = gears_.gear() == gears_.coming() && gears_.gear() != 0;
  if (gears_.shifting() && !gear_is_in)
    return std::min(crankshaft_nm(car.engine, rpm, throttle), gears_.clutch_capacity_nm());
  if (!gears_.shifting() && !gears_.handing_over()) return crankshaft_nm(car.engine, rpm, throttle);
  // The engine is brought to the speed of the new gear, beside what the clutch takes from it.
  const double target_rpm = gears_.handing_over() ? gears_.engine_target_rpm()
                                                  : mean_spin_radps() * gear_ratio(car, gears_.gear()) * rpm_per_radps;
  const double target = std::clamp(target_rpm, car.engine.idle_rpm, car.engine.limit_rpm) / rpm_per_radps;
  const double carried = gears_.handing_over() ? gears_.carried_nm() : 0.0;
  const double wanted =
      carried + car.engine.inertia_kgm2 * (target - engine_radps_) / std::max(0.25 * car.gearbox.shift_s, dt_s);
  return std::clamp(wanted, crankshaft_nm(car.engine, rpm, 0.0), crankshaft_nm(car.engine, rpm, 1.0));
}

double DriveTrain::mean_spin_radps() const {
  double mean = 0.0;
  for (std::size_t i = 0; i < 4; ++i) mean += share_[i] * wheels_[i].spin_radps;
  return mean;
}

void DriveTrain::control_slip(const CarParameters& car, double dt_s, const Pedals& pedals,
                              const std::array<WheelLoad, 4>& wheels) {
  double most = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double slip = wheel_slip(wheels[i]);
    if (share_[i] > 0.0) most = std::max(most, slip);
    const bool active =
        car.brakes.abs_slip > 0.0 && pedals.brake > 0.0 && std::abs(wheels[i].speed_mps) > abs_least_mps;
    abs_[i] = active ? controlled(abs_[i], -slip, car.brakes.abs_slip, abs_gain_1ps, dt_s, 0.02) : 1.0;
  }
  const double target = car.brakes.traction_slip;
  if (target <= 0.0) return;
  traction_held_ = controlled(traction_held_, most, target, traction_gain_1ps, dt_s, 0.0);
  traction_ = std::clamp(traction_held_ - traction_at_once * std::max((most - target) / target, 0.0), 0.0, 1.0);
}

void DriveTrain::solve_friction(Sweep& s) {
  Friction& f = impulse_;
  // Start with the impulses of the last step, as far as this one allows them.
  f.clutch = std::clamp(f.clutch, -s.clutch_limit, s.clutch_limit);
  s.push_engine(s.through_clutch(f.clutch), f.clutch);
  s.start_lock(0, s.front_share > 0.0 ? s.axle_limit(f.clutch, true) : 0.0, f.front);
  s.start_lock(2, s.front_share < 1.0 ? s.axle_limit(f.clutch, false) : 0.0, f.rear);
  for (std::size_t i = 0; i < 4; ++i) {
    f.hold[i] = std::clamp(f.hold[i], -s.hold_limit[i], s.hold_limit[i]);
    s.spin[i] -= f.hold[i] * s.inverse_inertia[i];
  }
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    const std::array<double, 4> spin_before = s.spin;
    const double engine_before = s.engine;
    s.clutch(f.clutch);
    if (s.front_share > 0.0) s.lock(0, s.axle_limit(f.clutch, true), f.front);
    if (s.front_share < 1.0) s.lock(2, s.axle_limit(f.clutch, false), f.rear);
    if (s.centre_limit > 0.0) s.centre(sweep == 0, f.centre);
    for (std::size_t i = 0; i < 4; ++i) {
      const double before = f.hold[i];
      f.hold[i] = std::clamp(before + s.spin[i] * inertia_[i], -s.hold_limit[i], s.hold_limit[i]);
      s.spin[i] -= (f.hold[i] - before) * s.inverse_inertia[i];
    }
    double change = std::abs(s.engine - engine_before);
    for (std::size_t i = 0; i < 4; ++i) change = std::max(change, std::abs(s.spin[i] - spin_before[i]));
    if (change < settled_radps) break;
  }
}

void DriveTrain::step(const CarParameters& car, double dt_s, const Pedals& pedals,
                      const std::array<WheelLoad, 4>& wheels) {
  control_slip(car, dt_s, pedals, wheels);
  const double wheel_rpm = mean_spin_radps() * rpm_per_radps;
  gears_.step(
      car, {dt_s, pedals.automatic, pedals.gear, pedals.throttle, pedals.brake, pedals.clutch,
            engine_radps_ * rpm_per_radps, wheel_rpm,
            crankshaft_nm(car.engine, wheel_rpm * gear_ratio(car, gears_.gear()), throttle_), impulse_.clutch / dt_s});
  const bool opening = gears_.shifting() && gears_.gear() != gears_.coming();
  const double wanted = opening ? 0.0 : pedals.throttle * traction_;
  throttle_ += (wanted - throttle_) * dt_s / (throttle_lag_s + dt_s);
  engine_nm_ = engine_torque(car, dt_s, throttle_);

  const double ratio = gear_ratio(car, gears_.gear());
  Sweep s;
  s.inverse_engine = 1.0 / car.engine.inertia_kgm2;
  s.engine = engine_radps_ + dt_s * engine_nm_ * s.inverse_engine;
  s.efficiency = car.gearbox.efficiency;
  s.clutch_limit = dt_s * gears_.clutch_capacity_nm();
  const Differential& d = car.differential;
  s.front_share = d.front_share;
  s.preload = dt_s * d.preload_nm;
  s.centre_limit = d.front_share > 0.0 && d.front_share < 1.0 ? dt_s * d.centre_preload_nm : 0.0;
  s.ramp_drive = d.ramp_drive;
  s.ramp_coast = d.ramp_coast;
  s.ratio = ratio;
  s.clutch_response = s.inverse_engine;
  std::array<double, 4> before{};
  for (std::size_t i = 0; i < 4; ++i) {
    before[i] = wheels_[i].spin_radps;
    s.inverse_inertia[i] = 1.0 / inertia_[i];
    s.spin[i] = before[i] - dt_s * wheels[i].tyre_nm * s.inverse_inertia[i];
    s.speed_share[i] = share_[i] * ratio;
    s.clutch_response += s.speed_share[i] * s.speed_share[i] * s.inverse_inertia[i];
    const double brake_nm = pedals.brake * abs_[i] * (i < 2 ? car.brakes.front_nm : car.brakes.rear_nm);
    s.hold_limit[i] = dt_s * (brake_nm + wheels[i].rolling_nm);
    wheels_[i].brake_nm = brake_nm;
  }
  solve_friction(s);
  account(car, dt_s, before, wheels, s);
}

void DriveTrain::account(const CarParameters& car, double dt_s, const std::array<double, 4>& spin_before,
                         const std::array<WheelLoad, 4>& wheels, const Sweep& s) {
  const double engine_mean = 0.5 * (engine_radps_ + s.engine);
  engine_w_ = engine_nm_ * engine_mean;
  fuel_w_ = vehicle::fuel_w(car.engine, engine_radps_ * rpm_per_radps, engine_nm_);
  engine_radps_ = s.engine;
  const double clutch_nm = impulse_.clutch / dt_s;
  transmission_w_ = clutch_nm * engine_mean;
  brakes_w_ = rolling_w_ = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    WheelSpin& w = wheels_[i];
    const double mean = 0.5 * (spin_before[i] + s.spin[i]);
    w.acceleration_radps2 = (s.spin[i] - spin_before[i]) / dt_s;
    w.spin_radps = s.spin[i];
    const double hold_nm = impulse_.hold[i] / dt_s, limit_nm = w.brake_nm + wheels[i].rolling_nm;
    const double brake_share = limit_nm > 0.0 ? w.brake_nm / limit_nm : 0.0;
    w.brake_nm = brake_share * hold_nm;
    w.rolling_nm = hold_nm - w.brake_nm;
    w.drive_nm = inertia_[i] * w.acceleration_radps2 + wheels[i].tyre_nm + hold_nm;
    brakes_w_ += w.brake_nm * mean;
    rolling_w_ += w.rolling_nm * mean;
    transmission_w_ -= w.drive_nm * mean;
  }
}

double DriveTrain::energy_j(const CarParameters& car) const {
  double energy = 0.5 * car.engine.inertia_kgm2 * engine_radps_ * engine_radps_;
  for (std::size_t i = 0; i < 4; ++i) energy += 0.5 * inertia_[i] * wheels_[i].spin_radps * wheels_[i].spin_radps;
  return energy;
}

}  // namespace vehicle
