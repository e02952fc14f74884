// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a car is made of. Files of models/vehicles hold the values, each with its unit and source; read_car.hpp reads
// them.
//
// Frame (ISO 8855): x ahead, y left, z up. The origin of the car is in the middle of the wheelbase, on the centre line,
// at road level in the design position, which is at rest on a level road.

#include <array>
#include <string>
#include <vector>

namespace vehicle {

struct Body {
  double mass_kg = 0.0;      ///< of all, with driver and half a tank
  double wheelbase_m = 0.0;  ///< between the axles
  double front_share = 0.0;  ///< of the weight, on the front axle at rest
  double cg_height_m = 0.0;  ///< of all, over the road at rest
  double roll_inertia_kgm2 = 0.0, pitch_inertia_kgm2 = 0.0, yaw_inertia_kgm2 = 0.0;  ///< of all, about its c.g.
  double roll_yaw_product_kgm2 = 0.0;  ///< integral x z dm of all; 0 where not known
};

/// Everything is given at the wheel, so that lever ratios do not appear. Travel is positive upwards (bump).
struct Suspension {
  double track_m = 0.0;
  double unsprung_mass_kg = 0.0;      ///< of one wheel with its share of the links
  double spring_npm = 0.0;            ///< wheel rate
  double spring_cubic_npm3 = 0.0;     ///< progressive part: F = k u + k3 u^3
  double bump_damping_nspm = 0.0;     ///< at low speed, upwards
  double rebound_damping_nspm = 0.0;  ///< at low speed, downwards
  double damper_knee_mps = 0.0;       ///< beyond this speed the damper is softer
  double damper_fast_ratio = 1.0;     ///< slope beyond the knee as a share of that before it
  double bump_stop_m = 0.0;           ///< travel where the upper stop begins
  double rebound_stop_m = 0.0;        ///< travel downwards where the lower stop begins (positive number)
  double stop_stiffness_npm = 0.0;    ///< of both stops
  double anti_roll_npm = 0.0;         ///< force at a wheel per difference of the travels of both
  double roll_centre_m = 0.0;         ///< height over the road
  double drive_support_rad = 0.0;     ///< path of the wheel centre from the vertical, positive = anti-squat / anti-lift
  double brake_support_rad = 0.0;     ///< the same of the contact point with the brake locked, positive = anti-dive
  double camber_rad = 0.0;            ///< at rest, positive = top outwards
  double camber_per_travel_radpm = 0.0;  ///< change with travel; negative: top goes inwards in bump
  double toe_rad = 0.0;                  ///< at rest, positive = toe-in, of one wheel
};

/// Magic Formula: the subset of MF 6.1 in Pacejka, Tyre and Vehicle Dynamics (3rd ed. 2012), sec. 4.3.2, with the names
/// of that book. Shifts that come from ply steer and conicity are left out, so that left and right are mirror images.
struct Tyre {
  double radius_m = 0.0;               ///< unloaded
  double vertical_npm = 0.0;           ///< stiffness
  double vertical_nspm = 0.0;          ///< damping
  double wheel_inertia_kgm2 = 0.0;     ///< of wheel, tyre and brake disc about the axle
  double nominal_load_n = 0.0;         ///< F_z0
  double rolling_resistance = 0.0;     ///< q_sy1, share of the load
  double rolling_resistance_v4 = 0.0;  ///< q_sy4, its part with (V / 16.67 m/s)^4
  double relaxation_long_m = 0.0;      ///< sigma_kappa at the nominal load
  double relaxation_lat_m = 0.0;       ///< sigma_alpha at the nominal load
  // Longitudinal, eq. 4.E9 to 4.E18.
  double p_cx1 = 0.0, p_dx1 = 0.0, p_dx2 = 0.0, p_ex1 = 0.0, p_kx1 = 0.0, p_kx2 = 0.0, p_kx3 = 0.0;
  // Lateral, eq. 4.E19 to 4.E30. p_dy3: loss of grip with camber^2; p_ky6, p_ky7: camber stiffness.
  double p_cy1 = 0.0, p_dy1 = 0.0, p_dy2 = 0.0, p_dy3 = 0.0, p_ey1 = 0.0, p_ky1 = 0.0, p_ky2 = 0.0, p_ky6 = 0.0,
         p_ky7 = 0.0;
  // Pneumatic trail, eq. 4.E33 and 4.E40 to 4.E44.
  double q_bz1 = 0.0, q_cz1 = 0.0, q_dz1 = 0.0, q_ez1 = 0.0;
  // Combined slip, eq. 4.E50 to 4.E67.
  double r_bx1 = 0.0, r_bx2 = 0.0, r_cx1 = 0.0, r_by1 = 0.0, r_by2 = 0.0, r_cy1 = 0.0;
};

struct Steering {
  double ratio = 0.0;            ///< angle of the steering wheel over the mean of the front wheels
  double ackermann_share = 0.0;  ///< 0: both wheels parallel, 1: both axes meet on the rear axle
  double max_wheel_rad = 0.0;    ///< mean of the front wheels
  double max_wheel_rate_radps = 0.0;
};

struct Engine {
  std::vector<double> speed_rpm;  ///< rising
  std::vector<double> torque_nm;  ///< full load, at these speeds
  double drag_nm = 0.0;           ///< closed throttle: drag_nm + drag_nm_per_krpm rpm / 1000
  double drag_nm_per_krpm = 0.0;
  double idle_rpm = 0.0, limit_rpm = 0.0;
  double inertia_kgm2 = 0.0;     ///< with flywheel and clutch
  double fuel_efficiency = 0.0;  ///< indicated: work on the pistons per heat of the fuel
  double fuel_heat_jpkg = 0.0;   ///< lower heating value
};

struct Gearbox {
  std::vector<double> ratios;  ///< forward gears, first to last
  double reverse_ratio = 0.0;  ///< positive number
  double final_drive = 0.0;
  double efficiency = 0.0;              ///< from the clutch to the wheels
  double shift_s = 0.0;                 ///< without torque
  double launch_rpm = 0.0;              ///< the automatic clutch holds the engine about there at a standing start
  double clutch_nm = 0.0;               ///< what the closed clutch carries
  double up_rpm = 0.0, down_rpm = 0.0;  ///< automatic, full demand
  double up_calm_rpm = 0.0, down_calm_rpm = 0.0;  ///< automatic, no demand
};

struct Differential {
  double front_share = 0.0;        ///< of the torque: 1 front-wheel drive, 0 rear-wheel drive, between: all four
  double preload_nm = 0.0;         ///< locking torque between the wheels of a driven axle, always
  double ramp_drive = 0.0;         ///< and as a share of the torque of the axle under power
  double ramp_coast = 0.0;         ///< the same on the overrun
  double centre_preload_nm = 0.0;  ///< between the axles, all-wheel drive only
};

struct Brakes {
  double front_nm = 0.0, rear_nm = 0.0;  ///< of one wheel at full pedal
  double abs_slip = 0.0;                 ///< longitudinal slip that ABS holds (positive); 0: no ABS
  double traction_slip = 0.0;            ///< slip that traction control holds; 0: none
};

struct Aero {
  double air_density_kgpm3 = 0.0;
  double drag_area_m2 = 0.0;                                 ///< c_d A
  double front_lift_area_m2 = 0.0, rear_lift_area_m2 = 0.0;  ///< c_l A at the axles; negative: downforce
};

struct CarParameters {
  std::string name;
  Body body;
  Suspension front, rear;
  Tyre front_tyre, rear_tyre;
  Steering steering;
  Engine engine;
  Gearbox gearbox;
  Differential differential;
  Brakes brakes;
  Aero aero;
};

inline constexpr double gravity_mps2 = 9.81;

}  // namespace vehicle
