// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/lane_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace orthodrive {
namespace {

using roadquery::Lane;
using roadquery::Road;

constexpr double spacing_m = 1.0;
constexpr double blend_base_m = 12.0, blend_per_jump = 12.0;
constexpr double half_car_m = 0.9;
constexpr double edge_room_m = 1.4;  // drivers keep the middle of the car so far from the edge where they can

/// t of the centre of the outermost driving lane in that direction; on a narrow road nearer to its middle.
double lane_center_t(const Road& road, bool forward, double s) {
  const auto& section = roadquery::section_at(road, s);
  const bool right = forward != (road.driving_side == roadquery::DrivingSide::left);
  double outer = 0.0, center = 0.0;
  for (const Lane& lane : right ? section.right : section.left) {
    const double width = roadquery::lane_width(lane, s - section.s);
    if (roadquery::is_driven(lane.type)) center = outer + 0.5 * width;
    outer += width;
  }
  const double t = roadquery::evaluate(road.lane_offset, s) + (right ? -center : center);
  const auto edges = driving_edges(road, s);
  const double middle = 0.5 * (edges.left_t + edges.right_t);
  return right ? std::max(t, std::min(edges.right_t + edge_room_m, middle))
               : std::min(t, std::max(edges.left_t - edge_room_m, middle));
}

double middle_t(const Road& road, double s) {
  const auto edges = driving_edges(road, s);
  return 0.5 * (edges.left_t + edges.right_t);
}

/// Where one is on a road after so many metres in that direction. Never beyond its ends: there are no lanes there, and
/// a sum that is 1e-14 m too long is beyond.
double station(const Road& road, bool forward, double driven_m) {
  return std::clamp(forward ? driven_m : road.length - driven_m, 0.0, road.length);
}

/// A step of the route with the shift to the left (in driving direction) that makes its ends meet its neighbours.
struct DrivenRoad {
  const Road* road = nullptr;
  bool forward = true;
  bool on_lane = true;  ///< else in the middle of the road
  double shift_begin_m = 0.0, shift_end_m = 0.0;

  [[nodiscard]] Vec2 point(double driven_m) const {
    const double s = station(*road, forward, driven_m);
    const double t = center_t(s) + (forward ? 1.0 : -1.0) * shift(driven_m);
    const auto p = roadquery::surface_point(*road, s, t);
    return {p.x, p.y};
  }
  /// Whether the lane centre shifted to the left by so much stays on the road with room for half a car.
  [[nodiscard]] bool has_room(double driven_m, double shift_m) const {
    const double s = station(*road, forward, driven_m);
    const double t = center_t(s) + (forward ? shift_m : -shift_m);
    const auto edges = driving_edges(*road, s);
    return t + half_car_m <= edges.left_t && t - half_car_m >= edges.right_t;
  }
  [[nodiscard]] Vec2 left(double driven_m) const {
    const double hdg = roadquery::reference_point(*road, station(*road, forward, driven_m)).hdg;
    const double sign = forward ? 1.0 : -1.0;
    return {-sign * std::sin(hdg), sign * std::cos(hdg)};
  }

 private:
  [[nodiscard]] double center_t(double s) const {
    return on_lane ? lane_center_t(*road, forward, s) : middle_t(*road, s);
  }
  [[nodiscard]] double shift(double driven_m) const {
    const auto fade = [&](double shift_m, double from_end_m) {
      const double over_m = std::min(blend_base_m + blend_per_jump * std::abs(shift_m), road->length);
      const double u = over_m > 0.0 ? std::clamp(1.0 - from_end_m / over_m, 0.0, 1.0) : 0.0;
      return shift_m * u * u * (3.0 - 2.0 * u);
    };
    return fade(shift_begin_m, driven_m) + fade(shift_end_m, road->length - driven_m);
  }
};

std::vector<DrivenRoad> join_lanes(const roadquery::RoadMap& map, const Route& route, bool on_lane) {
  std::vector<DrivenRoad> roads;
  roads.reserve(route.steps.size());
  for (const RouteStep& step : route.steps) {
    roads.push_back({&map.roads[static_cast<std::size_t>(step.road)], step.forward, on_lane});
  }
  const std::size_t joints = route.closed ? roads.size() : roads.size() - 1;
  std::vector<std::pair<double, double>> shifts(joints);  // at the end of the one road, at the start of the next
  for (std::size_t i = 0; i < joints; ++i) {
    const DrivenRoad &a = roads[i], &b = roads[(i + 1) % roads.size()];
    const double end_m = a.road->length;
    const double jump_m = dot(b.point(0.0) - a.point(end_m), a.left(end_m));
    const bool room_before = a.has_room(end_m, jump_m), room_after = b.has_room(0.0, -jump_m);
    const double share_before = room_before == room_after ? 0.5 : room_before ? 1.0 : 0.0;
    shifts[i] = {share_before * jump_m, (share_before - 1.0) * jump_m};
  }
  for (std::size_t i = 0; i < joints; ++i) {
    roads[i].shift_end_m = shifts[i].first;
    roads[(i + 1) % roads.size()].shift_begin_m = shifts[i].second;
  }
  return roads;
}

/// A point of a road of the route, by the way driven on it.
struct RawPoint {
  Vec2 point;
  double half_width_m = 0.0;
  int step = 0;
};
using PointOf = std::function<RawPoint(int step, double driven_m)>;

/// The points of all steps, in steps of the same length; of a closed path the first is not repeated.
LanePath sample(const roadquery::RoadMap& map, const Route& route, const PointOf& point_of) {
  std::vector<RawPoint> raw;
  const auto add = [&](const RawPoint& p) {
    if (raw.empty() || distance(raw.back().point, p.point) > 1e-3) raw.push_back(p);
  };
  for (int step = 0; step < static_cast<int>(route.steps.size()); ++step) {
    const double road_m = map.roads[static_cast<std::size_t>(route.steps[static_cast<std::size_t>(step)].road)].length;
    const int pieces = std::max(1, static_cast<int>(std::ceil(road_m / (0.5 * spacing_m))));
    for (int k = 0; k <= pieces; ++k) add(point_of(step, road_m * k / pieces));
  }
  if (route.closed && raw.size() > 1) add(raw.front());
  std::vector<double> s(raw.size(), 0.0);
  for (std::size_t i = 1; i < raw.size(); ++i) s[i] = s[i - 1] + distance(raw[i].point, raw[i - 1].point);
  if (raw.size() < 2 || s.back() < least_route_m) {
    throw TooShortError(fmt::format("the route is only {:.1f} m long, need at least {:.0f} m to drive",
                                    s.empty() ? 0.0 : s.back(), least_route_m));
  }
  const auto count = static_cast<std::size_t>(std::lround(s.back() / spacing_m));
  LanePath path{.closed = route.closed};
  std::size_t segment = 0;
  for (std::size_t i = 0; i < count + (route.closed ? 0 : 1); ++i) {
    const double at = s.back() * static_cast<double>(i) / static_cast<double>(count);
    while (segment + 2 < raw.size() && s[segment + 1] < at) ++segment;
    const RawPoint &a = raw[segment], &b = raw[segment + 1];
    const double u = (at - s[segment]) / (s[segment + 1] - s[segment]);
    path.points.push_back(a.point * (1.0 - u) + b.point * u);
    path.half_width_m.push_back(std::min(a.half_width_m, b.half_width_m));
    path.step.push_back(u < 0.5 ? a.step : b.step);
  }
  return path;
}

}  // namespace

/// Outer borders of the outermost driving lanes: sidewalks and shoulders are no room to drive in.
roadquery::Edges driving_edges(const Road& road, double s) {
  const auto& section = roadquery::section_at(road, s);
  const auto width_m = [&](const std::vector<Lane>& lanes) {
    double outer = 0.0, driven = 0.0;
    for (const Lane& lane : lanes) {
      outer += roadquery::lane_width(lane, s - section.s);
      if (roadquery::is_driven(lane.type)) driven = outer;
    }
    return driven;
  };
  const double offset = roadquery::evaluate(road.lane_offset, s);
  return {offset + width_m(section.left), offset - width_m(section.right)};
}

namespace {
LanePath joined_path(const roadquery::RoadMap& map, const Route& route, bool on_lane) {
  const std::vector<DrivenRoad> roads = join_lanes(map, route, on_lane);
  return sample(map, route, [&](int step, double driven_m) {
    return RawPoint{roads[static_cast<std::size_t>(step)].point(driven_m), 0.0, step};
  });
}
}  // namespace

LanePath path_along_lanes(const roadquery::RoadMap& map, const Route& route) { return joined_path(map, route, true); }
LanePath path_along_centre(const roadquery::RoadMap& map, const Route& route) { return joined_path(map, route, false); }

LanePath path_along_middle(const roadquery::RoadMap& map, const Route& route) {
  return sample(map, route, [&](int step, double driven_m) {
    const RouteStep& on = route.steps[static_cast<std::size_t>(step)];
    const Road& road = map.roads[static_cast<std::size_t>(on.road)];
    const double s = station(road, on.forward, driven_m);
    const auto edges = driving_edges(road, s);
    const auto p = roadquery::surface_point(road, s, 0.5 * (edges.left_t + edges.right_t));
    return RawPoint{{p.x, p.y}, 0.5 * (edges.left_t - edges.right_t), step};
  });
}

}  // namespace orthodrive
