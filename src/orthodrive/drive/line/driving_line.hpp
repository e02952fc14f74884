// SPDX-License-Identifier: Apache-2.0
#pragma once
// The line that the driver follows along a route, with what the road does below.

#include <vector>

#include "orthodrive/drive/routes/route.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {

struct LinePoint {
  double s_m = 0.0;  ///< along the line, in plan
  double x_m = 0.0, y_m = 0.0;
  double heading_rad = 0.0;  ///< continuous: not wrapped at pi
  double curvature_1pm = 0.0;
  double z_m = 0.0;
  double gradient = 0.0;                ///< of the surface along the line
  double banking = 0.0;                 ///< of the surface across the line, rad, positive = left side higher
  double vertical_curvature_1pm = 0.0;  ///< of the profile along the line, positive = sag, negative = crest
  double friction = 1.0;
  int step = 0;  ///< of the route
};

struct DrivingLine {
  bool closed = false;
  std::vector<LinePoint> points;  ///< about 1 m apart; of a closed line the last point repeats the first, a lap on

  [[nodiscard]] double length_m() const { return points.empty() ? 0.0 : points.back().s_m; }
  /// Interpolated at s; a closed line goes on lap after lap, an open one goes on straight beyond its ends.
  [[nodiscard]] LinePoint at(double s_m) const;
};

/// How a road is driven.
enum class DrivingStyle {
  road,    ///< on one's own lane, at the speed that is allowed
  racing,  ///< on the line of least curvature over the whole width, at the car's limit
  centre   ///< along the middle of the road as it is, at the car's limit (thesis sec. 4.3.2)
};

/// Where the line may be, and how it is chosen there.
struct LineOptions {
  DrivingStyle style = DrivingStyle::road;
  double car_width_m = 1.8;  ///< over the tyres
  double wheelbase_m = 2.7;  ///< in narrow bends the rear wheels run further in and the front wheels further out
  double margin_m = 0.2;     ///< between the car and the edge, with what the car strays from its line
  double most_curvature_1pm = 0.25;  ///< the car steers no tighter: the line is made wider where there is room
};

/// Centre: the middle of the road's driving lanes, neither smoothed nor moved.
///
/// Racing: the minimum-curvature line between the edges of the roads, all their driving lanes (bounded_line.hpp).
///
/// Else along the outermost driving lane in each step's direction (lane_path.hpp), smoothed as stiffly as a driver
/// would steer: min sum |p - q|^2 + (15 m / 2 pi)^6 |p'''|^2, which damps waves shorter than 15 m. Where that would
/// lead a wheel off the asphalt it is moved sideways as little as need be and stays as smooth as it can: at first by
/// the room beside the line, then by where the wheels of a car on it would run (axle_line.hpp).
///
/// The car does not leave the road where it is wide enough. Throws Error for a route below 10 m.
[[nodiscard]] DrivingLine make_driving_line(const roadquery::RoadQuery& query, const Route& route,
                                            const LineOptions& options = {});

/// Heading and curvature along a line through these points; nothing of the road.
[[nodiscard]] DrivingLine plain_line(const std::vector<Vec2>& points, bool closed, const std::vector<int>& step = {});

/// Heading, curvature and what the road does along a line through these points, about 1 m apart, whose surface at the
/// first is near start_z_m. Of a closed line the first point is not repeated. `step`: of each point, or empty.
[[nodiscard]] DrivingLine line_through(const roadquery::RoadQuery& query, const std::vector<Vec2>& points, bool closed,
                                       double start_z_m, const std::vector<int>& step = {});

}  // namespace orthodrive
