// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/lap_table.hpp"

#include <fmt/format.h>

#include <array>
#include <iterator>

namespace orthodrive {
namespace {

constexpr std::array wheels = {"fl", "fr", "rl", "rr"};

void add_wheel_names(std::string& csv, const char* quantity, const char* unit) {
  for (const char* wheel : wheels) fmt::format_to(std::back_inserter(csv), ",{}_{}{}", quantity, wheel, unit);
}

void add_wheels(std::string& csv, const std::array<double, 4>& values, int decimals) {
  for (const double v : values) fmt::format_to(std::back_inserter(csv), ",{:.{}f}", v, decimals);
}

}  // namespace

std::string lap_csv(const DriveResult& result) {
  std::string csv =
      "t_s,s_m,x_m,y_m,z_m,heading_rad,pitch_rad,roll_rad,speed_mps,a_lon_mps2,a_lat_mps2,curvature_1pm,gradient,"
      "road_id,road_s_m,road_t_m,z_fl_m,z_fr_m,z_rl_m,z_rr_m,a_vert_mps2,planned_mps,line_error_m,banking_rad,"
      "yaw_rate_radps,side_slip_rad,steering_rad,throttle,brake,gear,engine_rpm,fuel_kg";
  add_wheel_names(csv, "load", "_n");
  add_wheel_names(csv, "slip_ratio", "");
  add_wheel_names(csv, "slip_angle", "_rad");
  add_wheel_names(csv, "fx", "_n");
  add_wheel_names(csv, "fy", "_n");
  csv += '\n';
  csv.reserve(csv.size() + result.samples.size() * 420);
  const auto out = std::back_inserter(csv);
  for (const DriveSample& s : result.samples) {
    fmt::format_to(out,
                   "{:.3f},{:.3f},{:.3f},{:.3f},{:.4f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},"
                   "{},{:.3f},{:.3f},{:.4f},{:.4f},{:.4f},{:.4f}",
                   s.t_s, s.s_m, s.x_m, s.y_m, s.z_m, s.heading_rad, s.pitch_rad, s.roll_rad, s.speed_mps, s.a_lon_mps2,
                   s.a_lat_mps2, s.curvature_1pm, s.gradient, s.road_id, s.road_s_m, s.road_t_m, s.wheel_z_m[0],
                   s.wheel_z_m[1], s.wheel_z_m[2], s.wheel_z_m[3]);
    fmt::format_to(out, ",{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f},{},{:.1f},{:.6f}",
                   s.a_vert_mps2, s.planned_mps, s.line_error_m, s.banking_rad, s.yaw_rate_radps, s.side_slip_rad,
                   s.steering_rad, s.throttle, s.brake, s.gear, s.engine_rpm, s.fuel_kg);
    add_wheels(csv, s.load_n, 1);
    add_wheels(csv, s.slip_ratio, 5);
    add_wheels(csv, s.slip_angle_rad, 5);
    add_wheels(csv, s.fx_n, 1);
    add_wheels(csv, s.fy_n, 1);
    csv += '\n';
  }
  return csv;
}

std::string cycle_csv(const DriveResult& result) {
  std::string csv = "time_s,speed_kmh,gradient_percent,height_m,distance_m,gear\n";
  for (std::size_t i = 0; i < result.samples.size(); i += 100) {  // samples are 10 ms apart
    const DriveSample& s = result.samples[i];
    fmt::format_to(std::back_inserter(csv), "{:.0f},{:.2f},{:.2f},{:.2f},{:.1f},{}\n", s.t_s, 3.6 * s.speed_mps,
                   100.0 * s.gradient, s.z_m, s.s_m, s.gear);
  }
  return csv;
}

}  // namespace orthodrive
