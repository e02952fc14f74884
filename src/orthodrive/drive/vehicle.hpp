#pragma once
// The car that is driven.

namespace orthodrive {

/// A mid-size passenger car. Single-track values after Genta, Motor Vehicle Dynamics, and typical 1.5 t hatchbacks.
struct Vehicle {
  double mass_kg = 1500.0;
  double yaw_inertia_kgm2 = 2500.0;
  double wheelbase_m = 2.70;
  double front_axle_m = 1.20;                  ///< from the centre of gravity ahead to the front axle
  double track_m = 1.55;                       ///< between left and right contact points
  double cornering_stiffness_front_n = 1.0e5;  ///< N/rad, of the axle
  double cornering_stiffness_rear_n = 1.2e5;
  double grip = 1.0;              ///< largest share of the weight that an axle can give as a force
  double max_steer_rad = 0.65;    ///< at the front wheels: a turning circle of about 8 m across
  double steer_rate_radps = 1.2;  ///< at the front wheels
  double steer_lag_s = 0.05;
  double max_power_w = 1.1e5;
  double max_drive_force_n = 6.0e3;  ///< in the lowest gear
  double drag_area_m2 = 0.65;        ///< c_d A
  double rolling_resistance = 0.012;

  [[nodiscard]] double rear_axle_m() const { return wheelbase_m - front_axle_m; }
};

/// What the driver asks of the car, well below its limits.
struct Driver {
  double max_lateral_mps2 = 4.0;  ///< in the plane of the road, beyond what banking gives
  double max_drive_mps2 = 2.5;
  double max_brake_mps2 = 4.0;
  double max_speed_mps = 36.0;  ///< about 130 km/h
};

}  // namespace orthodrive
