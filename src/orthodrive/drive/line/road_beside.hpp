// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much road there is to both sides of a line.

#include <optional>
#include <vector>

#include "orthodrive/drive/line/driving_line.hpp"

namespace orthodrive {

/// Distance from a point of the line to where no driving lane is any more, at most 4 m; below 0 where all road is on
/// the other side.
struct Room {
  double right_m = 0.0, left_m = 0.0;
};

/// One a point of the line (without the repeated last one of a closed line). Every road counts that a wheel would stand
/// on there: other lanes, and in junctions what connecting roads cover together. Within 1 cm where a gap is wider than
/// 0.1 m. Where a point is off the road one looks from the lane, which is `lane_m` to the left of it, one per point;
/// where that is no road either nothing is known and the room is 4 m.
[[nodiscard]] std::vector<Room> room_beside(const roadquery::RoadQuery& query, const DrivingLine& line,
                                            const std::vector<double>& lane_m);

/// Whether a car may stand there: a driving lane, or the paved area of a junction.
[[nodiscard]] bool is_for_driving(const roadquery::RoadMap& map, const roadquery::Hit& hit);

/// Such a place on the level of z_m: what lies above or below a bridge is no room beside it.
[[nodiscard]] std::optional<roadquery::Hit> place_for_car(const roadquery::RoadQuery& query, double x_m, double y_m,
                                                          double z_m, roadquery::Cursor& cursor);

}  // namespace orthodrive
