// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the steering of a car allows along a line.

#include <optional>
#include <vector>

#include "orthodrive/drive/car/envelope_table.hpp"
#include "orthodrive/drive/line/driving_line.hpp"
#include "vehicle/car_parameters.hpp"

namespace orthodrive {

/// Of the way of the middle of the wheelbase with the steering at its stop.
[[nodiscard]] double full_lock_curvature_1pm(const vehicle::CarParameters& car);

/// Slower than the law allows where the front wheels could not be turned as fast as the line bends, and where the front
/// axle, whose way bends more than the middle's while they turn, would be accelerated more than that to its side; near
/// the stop of the steering also where the slip of the tyres would take the car wide. `envelope`: of that car.
void slow_down_to_steer(const vehicle::CarParameters& car, const EnvelopeTable& envelope, const DrivingLine& line,
                        double max_lateral_mps2, std::vector<double>& legal_mps);

/// A bend of a line that the car cannot take in one go.
struct TightBend {
  double s_m = 0.0, x_m = 0.0, y_m = 0.0;  ///< where it gets too tight
  double curvature_1pm = 0.0;              ///< the largest mean over a wheelbase
  int step = 0;                            ///< of the route, where it ends
};
/// The first bend that is tighter than the steering allows over a wheelbase: a kink of a line is none.
[[nodiscard]] std::optional<TightBend> first_too_tight(const vehicle::CarParameters& car, const DrivingLine& line);

}  // namespace orthodrive
