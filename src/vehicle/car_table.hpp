// SPDX-License-Identifier: Apache-2.0
#pragma once
// Every value of a car: where it stands in a file, its unit and the range that is accepted. Reading, checking and the
// table of docs/vehicle.md all go through this list.

#include <string_view>

#include "vehicle/car_parameters.hpp"

namespace vehicle {

struct ValueRange {
  double least = 0.0, most = 0.0;
};

/// Calls one(section, key, unit, value, range), with value a double or a std::vector<double>, for each of them.
/// Parameters: CarParameters, const or not.
template <typename Parameters, typename One>
void for_each_suspension_value(std::string_view section, Parameters& s, One&& one) {
  one(section, "track_m", "m", s.track_m, ValueRange{0.5, 3.0});
  one(section, "unsprung_mass_kg", "kg", s.unsprung_mass_kg, ValueRange{5.0, 300.0});
  one(section, "spring_npm", "N/m", s.spring_npm, ValueRange{2e3, 1e6});
  one(section, "spring_cubic_npm3", "N/m3", s.spring_cubic_npm3, ValueRange{0.0, 1e9});
  one(section, "bump_damping_nspm", "N s/m", s.bump_damping_nspm, ValueRange{0.0, 3e4});
  one(section, "rebound_damping_nspm", "N s/m", s.rebound_damping_nspm, ValueRange{0.0, 3e4});
  one(section, "damper_knee_mps", "m/s", s.damper_knee_mps, ValueRange{0.0, 10.0});
  one(section, "damper_fast_ratio", "-", s.damper_fast_ratio, ValueRange{0.0, 2.0});
  one(section, "bump_stop_m", "m", s.bump_stop_m, ValueRange{0.0, 0.5});
  one(section, "rebound_stop_m", "m", s.rebound_stop_m, ValueRange{0.0, 0.5});
  one(section, "stop_stiffness_npm", "N/m", s.stop_stiffness_npm, ValueRange{0.0, 2e6});
  one(section, "anti_roll_npm", "N/m", s.anti_roll_npm, ValueRange{0.0, 1e6});
  one(section, "roll_centre_m", "m", s.roll_centre_m, ValueRange{-0.3, 0.6});
  one(section, "drive_support_rad", "rad", s.drive_support_rad, ValueRange{-0.5, 0.5});
  one(section, "brake_support_rad", "rad", s.brake_support_rad, ValueRange{-0.5, 0.5});
  one(section, "camber_rad", "rad", s.camber_rad, ValueRange{-0.2, 0.2});
  one(section, "camber_per_travel_radpm", "rad/m", s.camber_per_travel_radpm, ValueRange{-2.0, 2.0});
  one(section, "toe_rad", "rad", s.toe_rad, ValueRange{-0.05, 0.05});
}

template <typename Parameters, typename One>
void for_each_tyre_value(std::string_view section, Parameters& t, One&& one) {
  one(section, "radius_m", "m", t.radius_m, ValueRange{0.15, 1.0});
  one(section, "vertical_npm", "N/m", t.vertical_npm, ValueRange{5e4, 2e6});
  one(section, "vertical_nspm", "N s/m", t.vertical_nspm, ValueRange{0.0, 2e3});
  one(section, "wheel_inertia_kgm2", "kg m2", t.wheel_inertia_kgm2, ValueRange{0.2, 30.0});
  one(section, "nominal_load_n", "N", t.nominal_load_n, ValueRange{500.0, 5e4});
  one(section, "rolling_resistance", "-", t.rolling_resistance, ValueRange{0.0, 0.2});
  one(section, "rolling_resistance_v4", "-", t.rolling_resistance_v4, ValueRange{0.0, 0.01});
  one(section, "relaxation_long_m", "m", t.relaxation_long_m, ValueRange{0.02, 2.0});
  one(section, "relaxation_lat_m", "m", t.relaxation_lat_m, ValueRange{0.02, 2.0});
  one(section, "p_cx1", "-", t.p_cx1, ValueRange{1.0, 2.0});
  one(section, "p_dx1", "-", t.p_dx1, ValueRange{0.1, 3.0});
  one(section, "p_dx2", "-", t.p_dx2, ValueRange{-0.5, 0.1});
  one(section, "p_ex1", "-", t.p_ex1, ValueRange{-10.0, 1.0});
  one(section, "p_kx1", "-", t.p_kx1, ValueRange{5.0, 100.0});
  one(section, "p_kx2", "-", t.p_kx2, ValueRange{-2.0, 2.0});
  one(section, "p_kx3", "-", t.p_kx3, ValueRange{-1.0, 1.0});
  one(section, "p_cy1", "-", t.p_cy1, ValueRange{1.0, 2.0});
  one(section, "p_dy1", "-", t.p_dy1, ValueRange{0.1, 3.0});
  one(section, "p_dy2", "-", t.p_dy2, ValueRange{-0.5, 0.1});
  one(section, "p_dy3", "-", t.p_dy3, ValueRange{0.0, 20.0});
  one(section, "p_ey1", "-", t.p_ey1, ValueRange{-10.0, 1.0});
  one(section, "p_ky1", "-", t.p_ky1, ValueRange{5.0, 100.0});
  one(section, "p_ky2", "-", t.p_ky2, ValueRange{0.5, 10.0});
  one(section, "p_ky6", "-", t.p_ky6, ValueRange{0.0, 5.0});
  one(section, "p_ky7", "-", t.p_ky7, ValueRange{-2.0, 2.0});
  one(section, "q_bz1", "-", t.q_bz1, ValueRange{0.0, 50.0});
  one(section, "q_cz1", "-", t.q_cz1, ValueRange{0.0, 2.0});
  one(section, "q_dz1", "-", t.q_dz1, ValueRange{0.0, 0.5});
  one(section, "q_ez1", "-", t.q_ez1, ValueRange{-10.0, 1.0});
  one(section, "r_bx1", "-", t.r_bx1, ValueRange{0.0, 50.0});
  one(section, "r_bx2", "-", t.r_bx2, ValueRange{-50.0, 50.0});
  one(section, "r_cx1", "-", t.r_cx1, ValueRange{0.5, 2.0});
  one(section, "r_by1", "-", t.r_by1, ValueRange{0.0, 50.0});
  one(section, "r_by2", "-", t.r_by2, ValueRange{-50.0, 50.0});
  one(section, "r_cy1", "-", t.r_cy1, ValueRange{0.5, 2.0});
}

template <typename Parameters, typename One>
void for_each_drive_value(Parameters& car, One&& one) {
  auto& e = car.engine;
  one("engine", "speed_rpm", "1/min", e.speed_rpm, ValueRange{100.0, 3e4});
  one("engine", "torque_nm", "N m", e.torque_nm, ValueRange{0.0, 5e3});
  one("engine", "drag_nm", "N m", e.drag_nm, ValueRange{0.0, 500.0});
  one("engine", "drag_nm_per_krpm", "N m min/1000", e.drag_nm_per_krpm, ValueRange{0.0, 200.0});
  one("engine", "idle_rpm", "1/min", e.idle_rpm, ValueRange{300.0, 5e3});
  one("engine", "limit_rpm", "1/min", e.limit_rpm, ValueRange{1e3, 3e4});
  one("engine", "inertia_kgm2", "kg m2", e.inertia_kgm2, ValueRange{0.005, 10.0});
  one("engine", "fuel_efficiency", "-", e.fuel_efficiency, ValueRange{0.05, 1.0});
  one("engine", "fuel_heat_jpkg", "J/kg", e.fuel_heat_jpkg, ValueRange{1e6, 2e8});
  auto& g = car.gearbox;
  one("gearbox", "ratios", "-", g.ratios, ValueRange{0.1, 30.0});
  one("gearbox", "reverse_ratio", "-", g.reverse_ratio, ValueRange{0.1, 30.0});
  one("gearbox", "final_drive", "-", g.final_drive, ValueRange{0.5, 30.0});
  one("gearbox", "efficiency", "-", g.efficiency, ValueRange{0.5, 1.0});
  one("gearbox", "shift_s", "s", g.shift_s, ValueRange{0.0, 2.0});
  one("gearbox", "launch_rpm", "1/min", g.launch_rpm, ValueRange{500.0, 3e4});
  one("gearbox", "clutch_nm", "N m", g.clutch_nm, ValueRange{10.0, 1e4});
  one("gearbox", "up_rpm", "1/min", g.up_rpm, ValueRange{500.0, 3e4});
  one("gearbox", "down_rpm", "1/min", g.down_rpm, ValueRange{500.0, 3e4});
  one("gearbox", "up_calm_rpm", "1/min", g.up_calm_rpm, ValueRange{500.0, 3e4});
  one("gearbox", "down_calm_rpm", "1/min", g.down_calm_rpm, ValueRange{500.0, 3e4});
  auto& d = car.differential;
  one("differential", "front_share", "-", d.front_share, ValueRange{0.0, 1.0});
  one("differential", "preload_nm", "N m", d.preload_nm, ValueRange{0.0, 2e3});
  one("differential", "ramp_drive", "-", d.ramp_drive, ValueRange{0.0, 1.0});
  one("differential", "ramp_coast", "-", d.ramp_coast, ValueRange{0.0, 1.0});
  one("differential", "centre_preload_nm", "N m", d.centre_preload_nm, ValueRange{0.0, 5e3});
}

template <typename Parameters, typename One>
void for_each_value(Parameters& car, One&& one) {
  auto& b = car.body;
  one("body", "mass_kg", "kg", b.mass_kg, ValueRange{100.0, 1e4});
  one("body", "wheelbase_m", "m", b.wheelbase_m, ValueRange{1.0, 8.0});
  one("body", "front_share", "-", b.front_share, ValueRange{0.1, 0.9});
  one("body", "cg_height_m", "m", b.cg_height_m, ValueRange{0.05, 2.0});
  one("body", "roll_inertia_kgm2", "kg m2", b.roll_inertia_kgm2, ValueRange{10.0, 1e5});
  one("body", "pitch_inertia_kgm2", "kg m2", b.pitch_inertia_kgm2, ValueRange{10.0, 1e5});
  one("body", "yaw_inertia_kgm2", "kg m2", b.yaw_inertia_kgm2, ValueRange{10.0, 1e5});
  one("body", "roll_yaw_product_kgm2", "kg m2", b.roll_yaw_product_kgm2, ValueRange{-1e4, 1e4});
  for_each_suspension_value("front_suspension", car.front, one);
  for_each_suspension_value("rear_suspension", car.rear, one);
  for_each_tyre_value("front_tyre", car.front_tyre, one);
  for_each_tyre_value("rear_tyre", car.rear_tyre, one);
  auto& s = car.steering;
  one("steering", "ratio", "-", s.ratio, ValueRange{1.0, 50.0});
  one("steering", "ackermann_share", "-", s.ackermann_share, ValueRange{-1.0, 1.5});
  one("steering", "max_wheel_rad", "rad", s.max_wheel_rad, ValueRange{0.05, 1.0});
  one("steering", "max_wheel_rate_radps", "rad/s", s.max_wheel_rate_radps, ValueRange{0.05, 50.0});
  for_each_drive_value(car, one);
  auto& k = car.brakes;
  one("brakes", "front_nm", "N m", k.front_nm, ValueRange{0.0, 5e4});
  one("brakes", "rear_nm", "N m", k.rear_nm, ValueRange{0.0, 5e4});
  one("brakes", "abs_slip", "-", k.abs_slip, ValueRange{0.0, 1.0});
  one("brakes", "traction_slip", "-", k.traction_slip, ValueRange{0.0, 5.0});
  auto& a = car.aero;
  one("aero", "air_density_kgpm3", "kg/m3", a.air_density_kgpm3, ValueRange{0.0, 2.0});
  one("aero", "drag_area_m2", "m2", a.drag_area_m2, ValueRange{0.0, 10.0});
  one("aero", "front_lift_area_m2", "m2", a.front_lift_area_m2, ValueRange{-10.0, 5.0});
  one("aero", "rear_lift_area_m2", "m2", a.rear_lift_area_m2, ValueRange{-10.0, 5.0});
}

}  // namespace vehicle
