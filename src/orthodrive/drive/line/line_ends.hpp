// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a car can stand at the beginning and at the end of an open line.

#include "orthodrive/drive/line/driving_line.hpp"

namespace orthodrive {

/// From where to where the middle of the wheelbase can be on an open line.
struct LineEnds {
  double from_m = 0.0, to_m = 0.0;
};

/// Both axles keep half a metre to the ends of the line, and all wheels half a metre to the cross-sections with which
/// the first and the last road of the route begin and end: a car that stands askew there needs more way. A line that
/// ends on an earlier road has no such cross-section at its end.
[[nodiscard]] LineEnds room_for_wheels(const roadquery::RoadMap& map, const Route& route, const DrivingLine& line,
                                       const LineOptions& car);

}  // namespace orthodrive
