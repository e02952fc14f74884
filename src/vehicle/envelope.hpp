// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a car can do at its limit, quasi-steady: for planning speeds.

#include <array>

#include "vehicle/car_parameters.hpp"

namespace vehicle {

struct EnvelopeQuery {
  double speed_mps = 0.0;
  double normal_mps2 = gravity_mps2;  ///< gravity and road curvature along the road's normal: 9.81 on a level road
  double lateral_mps2 = 0.0;          ///< asked of the tyres, in the road plane, either sign
  double friction = 1.0;
};

/// In the road plane, all positive. Air and rolling resistance are included (drive: subtracted, brake: added), gravity
/// along a slope is not.
struct Envelope {
  double max_lateral_mps2 = 0.0;  ///< without longitudinal force, whatever lateral_mps2 is
  /// At lateral_mps2 on the level: grip, engine and what it spins up; may be negative near top speed.
  double max_drive_mps2 = 0.0;
  double max_brake_mps2 = 0.0;  ///< at lateral_mps2: grip and brakes
};

/// Loads of the four wheels from weight, air forces and load transfer (by roll stiffness and roll centres), forces from
/// the peaks of the Magic Formula joined by the friction ellipse. Driving unloads the front axle and braking the rear:
/// no more of it than leaves that axle its side force.
[[nodiscard]] Envelope envelope(const CarParameters& car, const EnvelopeQuery& query);

/// What the tyres give at query.lateral_mps2, were the engine without limits. Smooth, so that it can be tabulated; what
/// has kinks (the engine, the lesser of grip and brake) is applied afterwards.
struct Grip {
  double max_lateral_mps2 = 0.0;  ///< as in Envelope
  double driving_mps2 = 0.0;      ///< when both axles drive with all they can
  /// Ahead and backwards, up to where load that moves to the other axle leaves each enough for its side force.
  double holding_drive_mps2 = 0.0, holding_brake_mps2 = 0.0;
  std::array<double, 2> rolling_n{};  ///< of the axles along the car's way, when nothing drives or brakes
  std::array<double, 2> driving_n{};  ///< of the axles at driving_mps2
  std::array<double, 4> braking_n{};  ///< of the wheels with full brakes, which lock where brakes_n is more
  std::array<double, 4> brakes_n{};   ///< of the brakes themselves
};
[[nodiscard]] Grip grip_of(const CarParameters& car, const EnvelopeQuery& query);

/// Air and rolling resistance in N.
[[nodiscard]] double resistance_n(const CarParameters& car, double speed_mps, double normal_mps2);

/// What the engine can do at a speed.
struct FullDrive {
  double force_n = 0.0;      ///< largest force at the driven wheels, over all gears
  double spinning_kg = 0.0;  ///< what has to be spun up in that gear beside the car's mass
};
[[nodiscard]] FullDrive full_drive(const CarParameters& car, double speed_mps);

/// Wheels, and the engine in that gear (0: without it), as a mass that is accelerated along the road.
[[nodiscard]] double spinning_kg(const CarParameters& car, int gear);

}  // namespace vehicle
