#pragma once
// The line that the driver follows along a route: lane centres, joined smoothly, with what the road does below.

#include <vector>

#include "orthodrive/drive/route.hpp"
#include "roadquery/road_query.hpp"

namespace orthodrive {

struct LinePoint {
  double s_m = 0.0;  ///< along the line
  double x_m = 0.0, y_m = 0.0;
  double heading_rad = 0.0;  ///< continuous: not wrapped at pi
  double curvature_1pm = 0.0;
  double z_m = 0.0;
  double gradient = 0.0;  ///< of the surface along the line
  double banking = 0.0;   ///< of the surface across the line, positive = left side higher
};

struct DrivingLine {
  bool closed = false;
  std::vector<LinePoint> points;  ///< about 1 m apart; of a closed line the last point repeats the first, a lap on

  [[nodiscard]] double length_m() const { return points.empty() ? 0.0 : points.back().s_m; }
  /// Interpolated at s; a closed line goes on lap after lap, an open one goes on straight beyond its ends.
  [[nodiscard]] LinePoint at(double s_m) const;
};

/// Follows the outermost driving lane in each step's direction. Where the lane centres of two steps do not meet, the
/// jump is made up over 12 m a metre of it on the road that has room for it (half on each when both or neither have);
/// then the line is smoothed as stiffly as a driver would steer: min sum |p - q|^2 + (15 m / 2 pi)^6 |p'''|^2, which
/// damps waves shorter than 15 m.
///
/// Throws Error for a route that is too short to drive (below 10 m).
[[nodiscard]] DrivingLine make_driving_line(const roadquery::RoadQuery& query, const Route& route);

}  // namespace orthodrive
