// SPDX-License-Identifier: Apache-2.0
// What a car tells about itself, and how it is put on the road.

#include <algorithm>
#include <cmath>

#include "vehicle/car_model.hpp"
#include "vehicle/engine.hpp"
#include "vehicle/suspension.hpp"

namespace vehicle {
namespace {

constexpr double settle_step_s = 1e-3;
constexpr int settle_steps = 4000;
constexpr double settle_damping_1ps = 16.0;  // critical for a car that heaves with 1.3 Hz

Quaternion from_heading(double heading_rad) {
  return {std::cos(0.5 * heading_rad), 0.0, 0.0, std::sin(0.5 * heading_rad)};
}

}  // namespace

void Car::Model::report_wheels() {
  Powers& p = state.powers;
  p.tyre_slip = p.suspension = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Contact& c = contacts_[i];
    const WheelSpin& spin = train.wheels()[i];
    WheelState& w = state.wheels[i];
    w.load_n = c.load_n;
    w.fx_n = c.forces.fx_n;
    w.fy_n = c.forces.fy_n;
    w.aligning_nm = c.forces.mz_nm;
    w.camber_rad = c.lean;  // small: sine and angle agree to the third order
    w.spin_radps = spin.spin_radps;
    w.steer_rad = wheel_steer_[i];
    w.travel_m = travel_[i];
    w.travel_rate_mps = travel_rate_[i];
    w.drive_nm = spin.drive_nm;
    w.brake_nm = spin.brake_nm;
    w.hub_m = to_array(place_ + axes_ * c.hub);
    w.contact_m = to_array(place_ + axes_ * c.place);
    w.friction = c.friction;
    p.tyre_slip -= c.forces.fx_n * c.motion.slip_x_mps + c.forces.fy_n * c.motion.slip_y_mps;
    p.suspension += c.damping_w + damper_n(suspension(i), travel_rate_[i]) * travel_rate_[i];
  }
}

void Car::Model::report(double dt_s) {
  State& s = state;
  const Vec3 velocity = transposed_times(axes_, velocity_) + cross(rates_, geometry.cg);
  const Vec3 acceleration =
      accelerations_.linear + cross(accelerations_.angular, geometry.cg) + cross(rates_, cross(rates_, geometry.cg));
  const Vec3 origin = place_ + axes_ * geometry.origin;
  s.x_m = origin.x;
  s.y_m = origin.y;
  s.z_m = origin.z;
  s.heading_rad = std::atan2(axes_.x.y, axes_.x.x);
  s.pitch_rad = std::asin(std::clamp(-axes_.x.z, -1.0, 1.0));
  s.roll_rad = std::atan2(axes_.y.z, axes_.z.z);
  s.cg_m = to_array(place_ + axes_ * geometry.cg);
  s.speed_mps = velocity.x;
  s.lateral_mps = velocity.y;
  s.vertical_mps = velocity.z;
  s.rates_radps = to_array(rates_);
  s.acceleration_mps2 = to_array(acceleration);
  s.side_slip_rad = std::abs(velocity.x) > 0.1 ? std::atan2(velocity.y, std::abs(velocity.x)) : 0.0;
  s.steering_rad = steering_;
  s.engine_rpm = train.engine_radps() * rpm_per_radps;
  s.engine_nm = train.engine_nm();
  s.gear = train.gears().gear();
  s.shifting = train.gears().shifting();
  s.throttle = train.throttle();
  s.fuel_kg += dt_s * train.fuel_w() / car.engine.fuel_heat_jpkg;
  report_wheels();
  s.powers.engine = train.engine_w();
  s.powers.transmission = train.transmission_w();
  s.powers.brakes = train.brakes_w();
  s.powers.rolling = train.rolling_w();
  s.powers.air = air_w_;
  s.powers.fuel = train.fuel_w();
}

/// Lets height, roll, pitch and the four travels come to rest; place in the plane, heading and speed ahead stay.
void Car::Model::settle(double speed_mps, Ground& ground) {
  const double keep = std::exp(-settle_damping_1ps * settle_step_s);
  const Vec3 still = place_;
  for (int n = 0; n < settle_steps; ++n) {
    place_.x = still.x;
    place_.y = still.y;
    place_.z += settle_step_s * velocity_.z;
    turn_ = turned(turn_, settle_step_s * rates_);
    axes_ = matrix(turn_);
    for (std::size_t i = 0; i < 4; ++i) travel_[i] += settle_step_s * travel_rate_[i];
    velocity_ = {0.0, 0.0, velocity_.z};
    touch(ground);
    slide_with_weight();
    const double heave = velocity_.z;
    velocity_ = speed_mps * axes_.x;  // for the air alone
    const Accelerations a = accelerations(false);
    velocity_ = {0.0, 0.0, keep * (heave + settle_step_s * (axes_ * a.linear).z)};
    rates_ += settle_step_s * a.angular;
    const Vec3 up = transposed_times(axes_, {0.0, 0.0, 1.0});
    rates_ = keep * (rates_ - dot(rates_, up) * up);
    for (std::size_t i = 0; i < 4; ++i) travel_rate_[i] = keep * (travel_rate_[i] + settle_step_s * a.travel[i]);
  }
}

void Car::Model::place(double x_m, double y_m, double heading_rad, double speed_mps, Ground& ground, double z_guess_m) {
  state = State();
  train = DriveTrain(car);
  turn_ = from_heading(heading_rad);
  axes_ = matrix(turn_);
  rates_ = velocity_ = Vec3();
  accelerations_ = Accelerations();
  travel_.fill(0.0);
  travel_rate_.fill(0.0);
  set_steering(0.0);
  // The car's axes in the plane through the four points below the wheels.
  std::array<double, 4> z{};
  double mean = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 arm = axes_ * (geometry.wheels[i].hub - geometry.origin);
    const GroundPoint point = ground.at(static_cast<int>(i), x_m + arm.x, y_m + arm.y, z_guess_m);
    z[i] = std::isfinite(point.z_m) ? point.z_m : z_guess_m;
    mean += 0.25 * z[i];
  }
  const double climb = std::atan(0.5 * (z[0] + z[1] - z[2] - z[3]) / car.body.wheelbase_m);
  const double bank = std::atan((z[0] - z[1] + z[2] - z[3]) / (car.front.track_m + car.rear.track_m));
  turn_ = turned(turned(turn_, {0.0, -climb, 0.0}), {bank, 0.0, 0.0});
  axes_ = matrix(turn_);
  place_ = Vec3{x_m, y_m, mean} - axes_ * geometry.origin;
  for (std::size_t i = 0; i < 4; ++i) {
    contacts_[i] = Contact();
    contacts_[i].hub = geometry.wheels[i].hub;
    contacts_[i].place = contacts_[i].hub - Vec3{0.0, 0.0, geometry.wheels[i].hub.z - geometry.origin.z};
    deflection_[i].reset();
  }
  settle(speed_mps, ground);

  rates_ = Vec3();
  travel_rate_.fill(0.0);
  place_ += Vec3{x_m, y_m, place_.z + (axes_ * geometry.origin).z} - (place_ + axes_ * geometry.origin);
  velocity_ = speed_mps * axes_.x;
  touch(ground);
  std::array<double, 4> spin{};
  for (std::size_t i = 0; i < 4; ++i) {
    spin[i] = contacts_[i].motion.ahead_mps / contacts_[i].rolling_m;
    if (speed_mps == 0.0) deflection_[i].hold(tyre(i), contacts_[i].forces.fx_n, contacts_[i].forces.fy_n);
  }
  train.place(car, spin);
  report(0.0);
}

}  // namespace vehicle
