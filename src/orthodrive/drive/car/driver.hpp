// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a driver asks of a car.

namespace orthodrive {

/// Accelerations in the plane of the road. The default drives passengers: Bosch, Automotive Handbook, calls 3 m/s2
/// comfortable; bends of country roads are driven at up to 4 m/s2 (RAL 2012 designs for less).
struct Driver {
  double max_lateral_mps2 = 4.0;  ///< asked of the tyres, beyond what banking gives
  double max_drive_mps2 = 2.5;
  double max_brake_mps2 = 3.0;
  double max_vertical_mps2 = 2.5;  ///< by crests and sags, and banking in bends
  double max_heave_mps2 = 2.0;     ///< of the body on its springs, over bumps
  double max_speed_mps = 36.0;     ///< about 130 km/h
  double grip_share = 0.85;        ///< of what the car can do (vehicle/envelope.hpp), at most
  double exit_share = 0.75;        ///< share of the lateral limit from which on there is no drive left
  double stop_s = 2.0;             ///< stands so long where it has to stop
  double speed_memory_s = 120.0;   ///< so long counts what was missing to the planned speed
};

/// Drives as fast as the car can.
[[nodiscard]] constexpr Driver racing_driver() {
  constexpr double no_limit = 1e3;
  return {no_limit, no_limit, no_limit, no_limit, no_limit, 120.0, 0.95, 0.92, 0.0, 30.0};
}

}  // namespace orthodrive
