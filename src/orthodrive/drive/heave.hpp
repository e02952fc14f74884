#pragma once
// How the body of a car moves up and down on its springs along a line: for planning speeds over bumps.

#include <vector>

#include "orthodrive/drive/driving_line.hpp"
#include "vehicle/car_parameters.hpp"

namespace orthodrive {

/// Largest vertical acceleration, either sign, of the body near every point of the line at these speeds in m/s2. One
/// mass on springs and dampers over the mean of both axles' heights (the middle of the wheels, by their share of the
/// weight).
[[nodiscard]] std::vector<double> heave_mps2(const DrivingLine& line, const std::vector<double>& speed_mps,
                                             const vehicle::CarParameters& car);

}  // namespace orthodrive
