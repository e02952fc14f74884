// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/driver_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/drive/line/axle_line.hpp"
#include "orthodrive/geo/angle.hpp"
#include "vehicle/envelope.hpp"

namespace orthodrive {
namespace {

using vehicle::CarParameters;
using vehicle::State;

constexpr double look_ahead_s = 0.08;      // of side forces: about the lag of tyre relaxation
constexpr double stanley_gain_1ps = 4.0;   // Hoffmann et al. 2007: 2.5, without knowing what slip the bend needs
constexpr double stanley_speed_mps = 1.0;  // keeps the correction finite at rest, ibid.
constexpr double speed_gain_1ps = 1.5;     // of the speed controller
constexpr double speed_gain_1ps2 = 0.3;    // its integral
constexpr double integral_reach_mps = 1.0;
constexpr double launch_m = 1.5,
                 launch_mps = 1.5;  // the plan so far ahead counts while it is that slow: at rest it says 0
constexpr double creep_mps = 0.8;   // never slower on the way
constexpr double starting_mps = 3.0, at_rest_mps = 0.2, stop_reach_m = 4.0;
constexpr double slip_matters_mps = 5.0, past_peak = 1.1;
constexpr double wide_enough_m = 0.6, lift_1ps2 = 5.0, lift_only_mps2 = 0.2;
constexpr double hold_brake = 0.4;

/// Force of the brakes at full pedal, with grip to spare.
double full_brake_n(const CarParameters& car) {
  return 2.0 * (car.brakes.front_nm / car.front_tyre.radius_m + car.brakes.rear_nm / car.rear_tyre.radius_m);
}

/// Air and rolling resistance.
double resistance_n(const CarParameters& car, double speed_mps) {
  return 0.5 * car.aero.air_density_kgpm3 * car.aero.drag_area_m2 * speed_mps * speed_mps +
         car.front_tyre.rolling_resistance * car.body.mass_kg * vehicle::gravity_mps2;
}

}  // namespace

void Progress::update(const DrivingLine& line, Vec2 place) {
  for (int i = 0; i < 3; ++i) {  // the line is nearly straight over one step: Newton converges at once
    const LinePoint p = line.at(s_m);
    const double c = std::cos(p.heading_rad), s = std::sin(p.heading_rad);
    const double dx = place.x - p.x_m, dy = place.y - p.y_m;
    error_m = dy * c - dx * s;
    s_m += (dx * c + dy * s) / std::max(1.0 - p.curvature_1pm * error_m, 0.2);
  }
}

DriverModel::DriverModel(const CarParameters& car, const EnvelopeTable& envelope, const Driver& driver,
                         const DrivingLine& line, const SpeedPlan& plan, std::vector<double> stops_m)
    : car_(car),
      envelope_(envelope),
      driver_(driver),
      line_(line),
      plan_(plan),
      stops_m_(std::move(stops_m)),
      front_line_(way_of_front_axle()) {}

void DriverModel::begin(double s_m) {
  const auto at = std::lower_bound(line_.points.begin(), line_.points.end() - 1, s_m,
                                   [](const LinePoint& p, double s) { return p.s_m < s; });
  middle_ = {s_m}, front_ = {front_line_.points[static_cast<std::size_t>(at - line_.points.begin())].s_m};
  next_stop_ = 0, waited_s_ = 0.0, integral_mps2_ = 0.0;
  while (next_stop_ < stops_m_.size() && stops_m_[next_stop_] < s_m) ++next_stop_;
}

double DriverModel::side_share(const LinePoint& p, double speed_mps) const {
  const RoadLoad load = road_load(p, speed_mps);
  const double down_mps2 = -0.5 * car_.aero.air_density_kgpm3 *
                           (car_.aero.front_lift_area_m2 + car_.aero.rear_lift_area_m2) * speed_mps * speed_mps /
                           car_.body.mass_kg;
  return load.lateral_mps2 / (std::max(load.normal_mps2 + down_mps2, 1.0) * std::max(p.friction, 0.05));
}

DrivingLine DriverModel::way_of_front_axle() const {
  const AxleSlip& rear = envelope_.rear_slip();
  std::vector<double> slip_rad;
  slip_rad.reserve(line_.points.size());
  for (const LinePoint& p : line_.points) {
    slip_rad.push_back(rear.angle_rad(side_share(p, plan_.at(p.s_m).speed_mps)));
  }
  return front_axle_line(line_, car_.body.wheelbase_m, car_headings(line_, car_.body.wheelbase_m, slip_rad));
}

double DriverModel::steering_rad(const State& state) const {
  const double speed = std::max(state.speed_mps, 0.0), wheelbase = car_.body.wheelbase_m;
  const double axle_m = wheelbase * (1.0 - car_.body.front_share);  // before the c.g.
  const double sideways_mps = state.lateral_mps + axle_m * state.rates_radps[2];
  const double going_mps = std::hypot(speed, sideways_mps);
  const double heading = wrapped_angle(front_line_.at(front_.s_m).heading_rad - state.heading_rad);
  // The front axle is accelerated along its own way, which is not the one that the middle will take.
  LinePoint ahead = line_.at(middle_.s_m + 0.5 * wheelbase + speed * look_ahead_s);
  ahead.curvature_1pm = front_line_.at(front_.s_m + going_mps * look_ahead_s).curvature_1pm;
  const double slip = envelope_.front_slip().angle_rad(side_share(ahead, going_mps));
  const double wanted_rad = heading + slip - std::atan(stanley_gain_1ps * front_.error_m / (stanley_speed_mps + speed));
  if (speed < slip_matters_mps) return wanted_rad;
  // Beyond the peak of the tyres more steering gives less force: not further than that from where the axle goes.
  const double going_rad = std::atan2(sideways_mps, speed);
  const double most_rad = past_peak * envelope_.front_slip().peak_rad();
  return std::clamp(wanted_rad, going_rad - most_rad, going_rad + most_rad);
}

double DriverModel::most_drive_here_mps2(const LinePoint& p, double speed_mps) const {
  const double able = most_drive_mps2(envelope_, driver_, p, speed_mps);
  // Who runs wide lifts.
  const double wide_m = -std::copysign(middle_.error_m, middle_.error_m * p.curvature_1pm) - wide_enough_m;
  return std::max(able - lift_1ps2 * std::max(wide_m, 0.0), std::min(able, -lift_only_mps2));  // no brake in a bend
}

bool DriverModel::holds(const State& state, double dt_s) {
  if (next_stop_ >= stops_m_.size() || stops_m_[next_stop_] - middle_.s_m > stop_reach_m) return false;
  if (waited_s_ <= 0.0 && state.speed_mps > at_rest_mps) return false;
  waited_s_ += dt_s;
  if (waited_s_ < driver_.stop_s) return true;
  ++next_stop_, waited_s_ = 0.0, integral_mps2_ = 0.0;
  return false;
}

double DriverModel::wanted_force_n(const State& state, double dt_s) {
  const bool stop_ahead = next_stop_ < stops_m_.size();
  const double look_m = stop_ahead ? std::clamp(stops_m_[next_stop_] - middle_.s_m, 0.0, launch_m) : launch_m;
  const SpeedPlan::At here = plan_.at(middle_.s_m), ahead = plan_.at(middle_.s_m + look_m);
  const bool stopping = stop_ahead && stops_m_[next_stop_] - middle_.s_m < stop_reach_m;
  const bool launching = here.speed_mps < launch_mps;
  const double wanted_mps = stopping    ? ahead.speed_mps
                            : launching ? std::max({here.speed_mps, std::min(ahead.speed_mps, 5.0), creep_mps})
                                        : here.speed_mps;
  const double error_mps = wanted_mps - state.speed_mps;
  const LinePoint p = line_.at(middle_.s_m);
  // Who starts again just before a stop does not brake for it any more.
  const bool starting = !stopping && state.speed_mps < starting_mps;
  const double planned_mps2 = starting ? std::max(here.acceleration_mps2, 0.0) : here.acceleration_mps2;
  const double asked_mps2 = planned_mps2 + speed_gain_1ps * error_mps + integral_mps2_;
  const double most_mps2 = most_drive_here_mps2(p, std::max(state.speed_mps, 0.0)),
               least_mps2 = -1.5 * driver_.max_brake_mps2;
  const double wanted_mps2 = std::max(std::min(asked_mps2, most_mps2), least_mps2);
  // Where the car does all it can already, as on full throttle, the integral would only wind up; what it holds fades.
  integral_mps2_ *= 1.0 - dt_s / driver_.speed_memory_s;
  const bool does_all = (asked_mps2 > most_mps2 && error_mps > 0.0) || (asked_mps2 < least_mps2 && error_mps < 0.0);
  if (!does_all && std::abs(error_mps) < integral_reach_mps) integral_mps2_ += speed_gain_1ps2 * error_mps * dt_s;
  // The side force of the steered wheels points backwards in part; a part of that turns the way of the c.g., which lies
  // before the rear axle and so runs inwards.
  const double turning_mps2 = car_.body.front_share * state.acceleration_mps2[1] * std::sin(state.steering_rad) -
                              state.rates_radps[2] * state.lateral_mps;
  // On the brakes the engine's own drag slows it down.
  const double spinning_kg = vehicle::spinning_kg(car_, wanted_mps2 > 0.0 ? state.gear : 0);
  return (car_.body.mass_kg + spinning_kg) * wanted_mps2 +
         car_.body.mass_kg * (road_load(p, state.speed_mps).slope_mps2 + turning_mps2) +
         resistance_n(car_, state.speed_mps);
}

vehicle::Controls DriverModel::drive(const State& state, double dt_s) {
  const double c = std::cos(state.heading_rad), s = std::sin(state.heading_rad);
  const double half_m = 0.5 * car_.body.wheelbase_m;
  middle_.update(line_, {state.x_m, state.y_m});
  front_.update(front_line_, {state.x_m + half_m * c, state.y_m + half_m * s});
  vehicle::Controls controls;
  controls.steering_rad = steering_rad(state);
  if (holds(state, dt_s)) {
    controls.brake = hold_brake;
    return controls;
  }
  const double force_n = wanted_force_n(state, dt_s);
  const double full_n = vehicle::full_drive(car_, std::max(state.speed_mps, 1.0)).force_n;
  if (force_n >= 0.0)
    controls.throttle = std::min(force_n / std::max(full_n, 1.0), 1.0);
  else
    controls.brake = std::min(-force_n / full_brake_n(car_), 1.0);
  return controls;
}

}  // namespace orthodrive
