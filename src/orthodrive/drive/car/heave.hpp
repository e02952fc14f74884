// SPDX-License-Identifier: Apache-2.0
#pragma once
// How the body of a car moves up and down on its springs along a line: for planning speeds over bumps.

#include <vector>

#include "orthodrive/drive/line/driving_line.hpp"
#include "vehicle/car_parameters.hpp"

namespace orthodrive {

/// Heights of the road under a car that follows a line: the mean of both wheels of an axle when the middle of the
/// wheelbase is at every 0.2 m of the line.
struct AxleHeights {
  static constexpr double step_m = 0.2;
  std::vector<double> front_m, rear_m;
};
[[nodiscard]] AxleHeights axle_heights(const roadquery::RoadQuery& query, const DrivingLine& line,
                                       const vehicle::CarParameters& car);

/// Largest vertical acceleration, either sign, of the body near every point of the line at these speeds in m/s2. Each
/// axle with its share of the body is a mass on springs and dampers on two wheels on their tyres (a quarter car,
/// doubled): the axles of a car do not disturb each other as long as its pitch inertia is about mass times the axles'
/// distances from the centre of gravity.
[[nodiscard]] std::vector<double> heave_mps2(const DrivingLine& line, const AxleHeights& heights,
                                             const std::vector<double>& speed_mps, const vehicle::CarParameters& car);

}  // namespace orthodrive
