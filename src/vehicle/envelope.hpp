#pragma once
// What a car can do at its limit, quasi-steady: for planning speeds.

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
  double max_drive_mps2 = 0.0;    ///< at lateral_mps2: grip and engine; may be negative near top speed
  double max_brake_mps2 = 0.0;    ///< at lateral_mps2: grip and brakes
};

/// Loads of the four wheels from weight, air forces and load transfer (by roll stiffness and roll centres), forces from
/// the peaks of the Magic Formula joined by the friction ellipse.
[[nodiscard]] Envelope envelope(const CarParameters& car, const EnvelopeQuery& query);

/// Largest force at the driven wheels in N at that speed, over all gears.
[[nodiscard]] double max_drive_force_n(const CarParameters& car, double speed_mps);

}  // namespace vehicle
