// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far a car's line may be moved sideways so that its wheels stay on the road.

#include <vector>

#include "orthodrive/drive/line/bounded_line.hpp"
#include "orthodrive/drive/line/driving_line.hpp"
#include "orthodrive/drive/line/line_ends.hpp"
#include "orthodrive/drive/line/road_beside.hpp"

namespace orthodrive {

/// Bounds of the line where there is asphalt from `right_m` right of the reference to `left_m` left of it.
/// At first sight: as if it had bent like the reference for long.
void bound(LineBetweenEdges& task, double right_m, double left_m, const LineOptions& options, double curvature_1pm);

/// Bounds of a line that moved from the reference whose `rooms` these are: each axle has room where it passes. Near
/// bends tighter than the car steers, and near places where it hardly fits, the driver uses the whole width.
void bound_by_axles(LineBetweenEdges& task, const std::vector<Room>& rooms, const DrivingLine& line,
                    const LineOptions& options);

/// Narrows the bounds of the line where a wheel of a car on it would leave the road; an open line counts from where to
/// where the car can stand. False: all wheels stay on it.
[[nodiscard]] bool keep_wheels_on_road(LineBetweenEdges& task, const std::vector<double>& offset,
                                       const roadquery::RoadQuery& query, const std::vector<Room>& rooms,
                                       const DrivingLine& line, LineEnds ends, const LineOptions& options);

}  // namespace orthodrive
