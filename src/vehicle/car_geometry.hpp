// SPDX-License-Identifier: Apache-2.0
#pragma once
// What follows from the parameters once and for all: where the masses are and how the hubs move.

#include <array>

#include "vehicle/car_parameters.hpp"
#include "vehicle/multibody.hpp"

namespace vehicle {

/// One wheel in the design position. Vectors in the car's axes from the c.g. of the body without wheels.
struct WheelGeometry {
  Vec3 hub;                      ///< place at zero travel
  Vec3 path;                     ///< of the hub with travel
  double turn_per_travel = 0.0;  ///< of the hub carrier about y, rad/m: gives the brake its support
  double side = 1.0;             ///< +1 left, -1 right
  double static_load_n = 0.0;    ///< of the tyre at rest on a level road
  double mass_kg = 0.0;
};

struct CarGeometry {
  SprungBody body;
  Vec3 origin;  ///< of the car (car_parameters.hpp), from the c.g. of the body
  Vec3 cg;      ///< of all
  double mass_kg = 0.0;
  std::array<WheelGeometry, 4> wheels;
};

[[nodiscard]] CarGeometry car_geometry(const CarParameters& car);

/// Load in N of one tyre of the axle at rest on a level road.
[[nodiscard]] double static_load_n(const CarParameters& car, bool front);

/// Angles of left and right front wheel for their mean, between parallel and Ackermann's.
[[nodiscard]] std::array<double, 2> front_wheel_angles(const CarParameters& car, double mean_rad);

}  // namespace vehicle
