// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the axles of a car run while the middle of its wheelbase follows a line.

#include <vector>

#include "orthodrive/drive/line/driving_line.hpp"

namespace orthodrive {

/// Heading of the car at every point of the line, continuous like the line's. The rear wheels do not move sideways but
/// for their slip: d heading / ds = (sin(line's heading - heading) + slip) 2 / wheelbase, positive slip in a left turn.
/// `rear_slip_rad`: one per point, or empty. An open line begins with the car along it.
[[nodiscard]] std::vector<double> car_headings(const DrivingLine& line, double wheelbase_m,
                                               const std::vector<double>& rear_slip_rad = {});

/// Way of the front axle, a point for each of the line: place, heading and curvature, no surface.
[[nodiscard]] DrivingLine front_axle_line(const DrivingLine& line, double wheelbase_m,
                                          const std::vector<double>& car_heading_rad);

/// How far to the left of the line each axle is when it passes the line's points.
struct AxleStrays {
  std::vector<double> front_m, rear_m;
};
[[nodiscard]] AxleStrays axle_strays(const DrivingLine& line, double wheelbase_m,
                                     const std::vector<double>& car_heading_rad);

/// Angle of the front wheels at every point, without slip of their tyres.
[[nodiscard]] std::vector<double> steering_angles(const DrivingLine& front, const std::vector<double>& car_heading_rad);

}  // namespace orthodrive
