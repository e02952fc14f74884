// SPDX-License-Identifier: Apache-2.0
#include "vehicle/car_model.hpp"

#include <algorithm>
#include <cmath>

#include "vehicle/suspension.hpp"

namespace vehicle {
namespace {

constexpr double least_load_n = 1.0;
constexpr double least_cosine = 0.2;         // a wheel that lies on its side does not roll
constexpr double deepest_share = 0.9;        // of the radius: forces stay finite whatever the ground says
constexpr double fastest_mps = 10.0;         // of the tyre's vertical damper, for the same reason
constexpr double rolling_share = 1.0 / 3.0;  // R_e = R_0 - rho / 3 (Pacejka, sec. 1.2.1: between R_0 and loaded radius)
constexpr double rolling_reference_mps = 16.67;  // LONGVL of the usual tyre files

double finite(double value) { return std::isfinite(value) ? value : 0.0; }

}  // namespace

Car::Model::Model(CarParameters p) : car(std::move(p)), geometry(car_geometry(car)), train(car) {
  set_steering(0.0);
  for (std::size_t i = 2; i < 4; ++i) {  // the rear wheels keep their toe
    wheel_steer_[i] = -geometry.wheels[i].side * car.rear.toe_rad;
    steer_cos_[i] = std::cos(wheel_steer_[i]);
    steer_sin_[i] = std::sin(wheel_steer_[i]);
  }
}

void Car::Model::set_steering(double mean_rad) {
  steering_ = mean_rad;
  const auto front = front_wheel_angles(car, mean_rad);
  for (std::size_t i = 0; i < 2; ++i) {
    wheel_steer_[i] = front[i] - geometry.wheels[i].side * car.front.toe_rad;
    steer_cos_[i] = std::cos(wheel_steer_[i]);
    steer_sin_[i] = std::sin(wheel_steer_[i]);
  }
}

void Car::Model::steer(double dt_s, double wanted_rad) {
  const Steering& s = car.steering;
  const double target = std::clamp(finite(wanted_rad), -s.max_wheel_rad, s.max_wheel_rad);
  const double largest = s.max_wheel_rate_radps * dt_s;
  const double next = steering_ + std::clamp(target - steering_, -largest, largest);
  if (next != steering_) set_steering(next);
}

/// Places from the speeds at the beginning of the step (the first half of semi-implicit Euler).
void Car::Model::move(double dt_s) {
  place_ += dt_s * velocity_;
  turn_ = turned(turn_, dt_s * rates_);
  axes_ = matrix(turn_);
  for (std::size_t i = 0; i < 4; ++i) travel_[i] += dt_s * travel_rate_[i];
}

void Car::Model::touch(Ground& ground) {
  for (std::size_t i = 0; i < 4; ++i) {
    Contact& c = contacts_[i];
    // Asked where the contact was in the car's axes a step ago.
    const Vec3 to_contact = c.place - c.hub;
    c.hub = geometry.wheels[i].hub + travel_[i] * geometry.wheels[i].path;
    const Vec3 guess = place_ + axes_ * (c.hub + to_contact);
    const GroundPoint point = ground.at(static_cast<int>(i), guess.x, guess.y, guess.z);
    WheelState& w = state.wheels[i];
    w.on_road = point.on_road;
    w.ground_z_m = point.z_m;
    w.contact_m = {guess.x, guess.y, point.z_m};
    touch_wheel(i, point);
  }
}

void Car::Model::touch_wheel(std::size_t i, const GroundPoint& ground) {
  Contact& c = contacts_[i];
  const Tyre& t = tyre(i);
  const WheelGeometry& g = geometry.wheels[i];
  c.load_n = c.damping_w = 0.0;
  c.friction = std::clamp(finite(ground.friction), 0.01, 10.0);
  const Vec3 normal = transposed_times(axes_, to_vec3(ground.normal));
  const Vec3 point = transposed_times(axes_, to_vec3(state.wheels[i].contact_m) - place_);
  const double camber =
      -g.side * (suspension(i).camber_rad + suspension(i).camber_per_travel_radpm * travel_[i]);  // about x
  const double camber_cos = 1.0 / std::sqrt(1.0 + camber * camber);  // of the angle whose tangent is `camber`
  c.axle = {-steer_sin_[i] * camber_cos, steer_cos_[i] * camber_cos, camber * camber_cos};
  const Vec3 along = cross(c.axle, normal);
  const double cosine = norm(along);
  const double distance = dot(normal, c.hub - point);
  const bool near = cosine > least_cosine && distance < t.radius_m * cosine && std::isfinite(distance);
  c.normal = normal;
  c.ahead = near ? (1.0 / cosine) * along : Vec3{steer_cos_[i], steer_sin_[i], 0.0};
  c.left = near ? cross(normal, c.ahead) : Vec3{-steer_sin_[i], steer_cos_[i], 0.0};
  c.lean = dot(c.axle, normal);
  c.loaded_m = near ? std::max(distance / cosine, (1.0 - deepest_share) * t.radius_m) : t.radius_m;
  c.place = c.hub - c.loaded_m * cross(c.ahead, c.axle);
  c.velocity = transposed_times(axes_, velocity_) + cross(rates_, c.place) + travel_rate_[i] * g.path;
  const double deflection_m = t.radius_m - c.loaded_m;
  c.rolling_m = t.radius_m - rolling_share * deflection_m;
  if (near) {
    const double rate = std::clamp(-dot(normal, c.velocity), -fastest_mps, fastest_mps);
    const double spring = t.vertical_npm * deflection_m;
    c.load_n = std::max(spring + t.vertical_nspm * rate, 0.0);
    c.damping_w = (c.load_n - spring) * rate;
  }
  const double spin = train.wheels()[i].spin_radps;
  c.motion.ahead_mps = dot(c.ahead, c.velocity);
  c.motion.slip_x_mps = c.motion.ahead_mps - spin * c.rolling_m;
  c.motion.slip_y_mps = dot(c.left, c.velocity);
}

void Car::Model::roll_tyres(double dt_s) {
  for (std::size_t i = 0; i < 4; ++i) {
    Contact& c = contacts_[i];
    c.forces = TyreForces();
    WheelState& w = state.wheels[i];
    if (c.load_n < least_load_n) {
      deflection_[i].reset();
      w.slip_ratio = w.slip_angle_rad = 0.0;
      continue;
    }
    const TyreGrip grip = tyre_grip(tyre(i), c.load_n, c.lean, c.friction);
    Slip slip = deflection_[i].step(dt_s, tyre(i), grip, c.motion);
    slip.lean = -c.lean;
    c.forces = magic_formula(tyre(i), c.load_n, c.friction, slip, grip);
    w.slip_ratio = slip.kappa;
    w.slip_angle_rad = -std::atan(slip.tan_alpha);
  }
}

/// While the car settles, the tyres hold it in the plane of the road: each by its share of the load.
void Car::Model::slide_with_weight() {
  const Vec3 gravity = transposed_times(axes_, {0.0, 0.0, -geometry.mass_kg * gravity_mps2});
  double load = 0.0;
  for (const Contact& c : contacts_) load += c.load_n;
  for (Contact& c : contacts_) {
    c.forces = TyreForces();
    if (load <= 0.0 || c.load_n <= 0.0) continue;
    c.forces.fx_n = -c.load_n / load * dot(gravity, c.ahead);
    c.forces.fy_n = -c.load_n / load * dot(gravity, c.left);
  }
}

double Car::Model::anti_roll_n(std::size_t i) const {
  return suspension(i).anti_roll_npm * (travel_[i] - travel_[i ^ 1U]);
}

Accelerations Car::Model::accelerations(bool wheels_turn) {
  std::array<Hub, 4> hubs;
  for (std::size_t i = 0; i < 4; ++i) {
    const Contact& c = contacts_[i];
    const WheelGeometry& g = geometry.wheels[i];
    const WheelSpin& spin = train.wheels()[i];
    Hub& hub = hubs[i];
    hub.mass_kg = g.mass_kg;
    hub.place = c.hub;
    hub.path = g.path;
    hub.rate_mps = travel_rate_[i];
    hub.force_n = c.forces.fx_n * c.ahead + c.forces.fy_n * c.left + c.load_n * c.normal;
    hub.moment_nm = cross(c.place, hub.force_n) + c.forces.mz_nm * c.normal;
    const double preload_n = g.static_load_n - g.mass_kg * gravity_mps2;
    hub.along_n =
        -preload_n - spring_n(suspension(i), travel_[i]) - damper_n(suspension(i), travel_rate_[i]) - anti_roll_n(i);
    if (wheels_turn) {
      // The tyre's force turns the wheel with the arm R_e, not with the loaded radius; rolling resistance acts from the
      // road as well. What spins up the wheel turns the body the other way, and a spinning wheel resists being turned.
      const double from_road_nm = -(c.rolling_m - c.loaded_m) * c.forces.fx_n - spin.rolling_nm;
      const double inertia = tyre(i).wheel_inertia_kgm2;
      hub.moment_nm += (from_road_nm - inertia * spin.acceleration_radps2) * c.axle -
                       (inertia * spin.spin_radps) * cross(rates_, c.axle);
      hub.along_n += spin.brake_nm * g.turn_per_travel;
    }
  }
  // Air: drag at the road below the origin, lift at the axles (SAE J1594).
  const Vec3 velocity = transposed_times(axes_, velocity_);
  const Aero& a = car.aero;
  const double half_density = 0.5 * a.air_density_kgpm3, pressure = half_density * velocity.x * velocity.x;
  const Vec3 drag = (-half_density * a.drag_area_m2 * norm(velocity)) * velocity;
  const double front_n = pressure * a.front_lift_area_m2, rear_n = pressure * a.rear_lift_area_m2;
  const double half_base_m = 0.5 * car.body.wheelbase_m;
  const Vec3 lift{0.0, 0.0, front_n + rear_n};
  const Vec3 lift_moment = cross(geometry.origin, lift) + Vec3{0.0, half_base_m * (rear_n - front_n), 0.0};
  air_w_ = -dot(drag, velocity + cross(rates_, geometry.origin)) - dot(lift, velocity) - dot(lift_moment, rates_);
  return solve_motion(geometry.body, rates_, transposed_times(axes_, {0.0, 0.0, -gravity_mps2}), drag + lift,
                      cross(geometry.origin, drag) + lift_moment, hubs);
}

void Car::Model::step(double dt_s, const Controls& controls, Ground& ground) {
  steer(dt_s, controls.steering_rad);
  move(dt_s);
  touch(ground);
  roll_tyres(dt_s);

  std::array<WheelLoad, 4> loads;
  for (std::size_t i = 0; i < 4; ++i) {
    const Contact& c = contacts_[i];
    const Tyre& t = tyre(i);
    const double relative = c.motion.ahead_mps / rolling_reference_mps, square = relative * relative;
    loads[i] = {c.forces.fx_n * c.rolling_m,
                c.load_n * c.rolling_m * (t.rolling_resistance + t.rolling_resistance_v4 * square * square),
                -c.motion.slip_x_mps, c.motion.ahead_mps};
  }
  const auto pedal = [](double value) { return std::clamp(finite(value), 0.0, 1.0); };
  train.step(
      car, dt_s,
      {pedal(controls.throttle), pedal(controls.brake), pedal(controls.clutch), controls.automatic, controls.gear},
      loads);

  accelerations_ = accelerations(true);
  velocity_ += dt_s * (axes_ * accelerations_.linear);
  rates_ += dt_s * accelerations_.angular;
  for (std::size_t i = 0; i < 4; ++i) travel_rate_[i] += dt_s * accelerations_.travel[i];
  state.t_s += dt_s;
  report(dt_s);
}

double Car::Model::energy_j() const {
  double energy = train.energy_j(car) + 0.5 * geometry.body.mass_kg * dot(velocity_, velocity_) +
                  0.5 * dot(rates_, geometry.body.inertia * rates_) + geometry.body.mass_kg * gravity_mps2 * place_.z;
  for (std::size_t i = 0; i < 4; ++i) {
    const WheelGeometry& g = geometry.wheels[i];
    const Vec3 hub = g.hub + travel_[i] * g.path;
    const Vec3 speed = transposed_times(axes_, velocity_) + cross(rates_, hub) + travel_rate_[i] * g.path;
    energy += 0.5 * g.mass_kg * dot(speed, speed) + g.mass_kg * gravity_mps2 * (place_ + axes_ * hub).z;
    energy += spring_j(suspension(i), travel_[i]) + (g.static_load_n - g.mass_kg * gravity_mps2) * travel_[i];
    energy += 0.25 * anti_roll_n(i) * (travel_[i] - travel_[i ^ 1U]);  // half of it for each wheel
    const double deflection_m = tyre(i).radius_m - contacts_[i].loaded_m;
    energy += 0.5 * tyre(i).vertical_npm * deflection_m * deflection_m;
    const CarcassStiffness carcass = carcass_stiffness(tyre(i));
    const double u = deflection_[i].u_m(), v = deflection_[i].v_m();
    energy += 0.5 * (carcass.long_npm * u * u + carcass.lat_npm * v * v);
  }
  return energy;
}

}  // namespace vehicle
