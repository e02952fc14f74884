// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/lap_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

constexpr double bump_m = 0.02;  // a step as high as a lowered kerb is worth a finding
constexpr double jolt_mps2 = 5.0;
constexpr double finding_spacing_m = 10.0;

void keep_extremes(DriveResult& result, const vehicle::State& state) {
  const auto& a = state.acceleration_mps2;
  result.max_speed_mps = std::max(result.max_speed_mps, state.speed_mps);
  result.max_lateral_mps2 = std::max(result.max_lateral_mps2, std::abs(a[1]));
  result.max_braking_mps2 = std::max(result.max_braking_mps2, -a[0]);
  result.max_driving_mps2 = std::max(result.max_driving_mps2, a[0]);
  result.max_vertical_mps2 = std::max(result.max_vertical_mps2, std::abs(a[2]));
  result.max_roll_rad = std::max(result.max_roll_rad, std::abs(state.roll_rad));
}

}  // namespace

void SpacedFindings::add(double s_m, Finding finding) {
  const bool near = s_m < last_s_m_ + finding_spacing_m;
  last_s_m_ = s_m;
  if (!near) findings_.push_back(std::move(finding));
}

LapRecorder::LapRecorder(const roadquery::RoadQuery& query, const SpeedPlan& plan, DriveResult& result)
    : query_(query),
      plan_(plan),
      result_(result),
      bumps_(result.findings),
      misses_(result.findings),
      jolts_(result.findings) {}

void LapRecorder::step(const vehicle::State& state, const DriverModel& driver, MonitoredRoad::Seen seen, double s_m) {
  const auto warn = [&](SpacedFindings& findings, const char* code, std::string what) {
    findings.add(s_m, {Severity::warning, code, std::move(what), state.x_m, state.y_m});
  };
  result_.tyre_queries += static_cast<std::uint64_t>(seen.queries);
  result_.tyre_misses += static_cast<std::uint64_t>(seen.missed);
  result_.max_line_error_m = std::max(result_.max_line_error_m, std::abs(driver.error_m()));
  keep_extremes(result_, state);
  const double up_mps2 = state.acceleration_mps2[2];
  if (seen.missed > 0)
    warn(misses_, "drive.off_road", fmt::format("a tyre leaves the road {:.0f} m into the lap", s_m));
  if (seen.step_m > bump_m)
    warn(bumps_, "drive.bump", fmt::format("the road surface has a step of {:.3f} m", seen.step_m));
  if (std::abs(up_mps2) > jolt_mps2)
    warn(jolts_, "drive.jolt",
         fmt::format("the body is accelerated vertically by {:+.1f} m/s2 at {:.0f} km/h", up_mps2,
                     3.6 * state.speed_mps));
  if (seen.step_m > result_.max_height_step_m)
    result_.max_height_step_m = seen.step_m, result_.max_height_step_s_m = s_m;
  if (first_fuel_kg_ < 0.0) first_fuel_kg_ = state.fuel_kg;
  result_.fuel_kg = state.fuel_kg - first_fuel_kg_;
}

void LapRecorder::sample(double t_s, const vehicle::State& state, const vehicle::Controls& controls,
                         const DriverModel& driver, double s_m) {
  const LinePoint place = result_.line.at(driver.s_m());
  result_.max_gradient = std::max(result_.max_gradient, place.gradient);
  result_.min_gradient = std::min(result_.min_gradient, place.gradient);
  if (has_z_) result_.climb_m += std::max(state.z_m - last_z_m_, 0.0);
  last_z_m_ = state.z_m, has_z_ = true;
  DriveSample out;
  out.t_s = t_s, out.s_m = s_m;
  out.x_m = state.x_m, out.y_m = state.y_m, out.z_m = state.z_m;
  out.heading_rad = state.heading_rad, out.pitch_rad = -state.pitch_rad, out.roll_rad = state.roll_rad;
  out.speed_mps = std::hypot(state.speed_mps, state.lateral_mps), out.planned_mps = plan_.at(driver.s_m()).speed_mps;
  out.a_lon_mps2 = state.acceleration_mps2[0], out.a_lat_mps2 = state.acceleration_mps2[1];
  out.a_vert_mps2 = state.acceleration_mps2[2];
  out.yaw_rate_radps = state.rates_radps[2], out.side_slip_rad = state.side_slip_rad;
  out.curvature_1pm = place.curvature_1pm, out.gradient = place.gradient, out.banking_rad = place.banking;
  out.line_error_m = driver.error_m();
  if (const auto hit = query_.find(state.x_m, state.y_m, state.z_m, cursor_)) {
    out.road_id = query_.map().roads[static_cast<std::size_t>(hit->road)].id;
    out.road_s_m = hit->s, out.road_t_m = hit->t;
  }
  out.steering_rad = state.steering_rad;
  out.throttle = controls.throttle, out.brake = controls.brake, out.gear = state.gear;
  out.engine_rpm = state.engine_rpm, out.fuel_kg = state.fuel_kg - std::max(first_fuel_kg_, 0.0);
  for (std::size_t i = 0; i < 4; ++i) {
    const vehicle::WheelState& wheel = state.wheels[i];
    out.wheel_z_m[i] = wheel.ground_z_m, out.load_n[i] = wheel.load_n;
    out.slip_ratio[i] = wheel.slip_ratio, out.slip_angle_rad[i] = wheel.slip_angle_rad;
    out.fx_n[i] = wheel.fx_n, out.fy_n[i] = wheel.fy_n;
  }
  result_.samples.push_back(out);
}

}  // namespace orthodrive
