// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/line_ends.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/drive/line/axle_line.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

constexpr double wheel_room_m = 0.5;  // kept to the ends

/// A cross-section of a road and the direction in which the route goes on from it.
struct CrossSection {
  Vec2 at, ahead;
};

CrossSection cross_section(const roadquery::RoadMap& map, const RouteStep& step, bool begin) {
  const roadquery::Road& road = map.roads[static_cast<std::size_t>(step.road)];
  const auto p = roadquery::reference_point(road, begin == step.forward ? 0.0 : road.length);
  const double sign = step.forward ? 1.0 : -1.0;
  return {{p.x, p.y}, {sign * std::cos(p.hdg), sign * std::sin(p.hdg)}};
}

/// Largest distance from a place of the middle to a wheel of that axle, along a direction.
double car_reach_m(const LineOptions& car, bool front, double heading_rad, Vec2 direction) {
  const Vec2 ahead{std::cos(heading_rad), std::sin(heading_rad)};
  return 0.5 * car.wheelbase_m * (front ? 1.0 : -1.0) * dot(ahead, direction) +
         0.5 * car.car_width_m * std::abs(cross(ahead, direction));
}

}  // namespace

LineEnds room_for_wheels(const roadquery::RoadMap& map, const Route& route, const DrivingLine& line,
                         const LineOptions& car) {
  constexpr double step_m = 0.05, tolerance_m = 1e-6;
  const double length_m = line.length_m(), room_m = 0.5 * car.wheelbase_m + wheel_room_m;
  const std::vector<double> heading = car_headings(line, car.wheelbase_m);
  const CrossSection first = cross_section(map, route.steps.front(), true),
                     last = cross_section(map, route.steps.back(), false);
  const auto room = [&](double s_m, const CrossSection& end, bool front, Vec2 outwards) {
    const LinePoint p = line.at(s_m);
    const auto near = std::lower_bound(line.points.begin(), line.points.end() - 1, s_m,
                                       [](const LinePoint& q, double s) { return q.s_m < s; });
    const double heading_rad = heading[static_cast<std::size_t>(near - line.points.begin())];
    return dot(end.at - Vec2{p.x_m, p.y_m}, outwards) - car_reach_m(car, front, heading_rad, outwards) - wheel_room_m;
  };
  LineEnds ends{std::min(room_m, 0.4 * length_m), 0.0};
  ends.to_m = length_m - ends.from_m;
  while (ends.from_m < 0.4 * length_m && room(ends.from_m, first, false, -1.0 * first.ahead) < -tolerance_m)
    ends.from_m += step_m;
  const bool whole = line.points.back().step + 1 == static_cast<int>(route.steps.size());
  while (whole && ends.to_m > 0.6 * length_m && room(ends.to_m, last, true, last.ahead) < -tolerance_m)
    ends.to_m -= step_m;
  return ends;
}

}  // namespace orthodrive
