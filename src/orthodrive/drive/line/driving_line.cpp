// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/driving_line.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "orthodrive/drive/line/bounded_line.hpp"
#include "orthodrive/drive/line/lane_bounds.hpp"
#include "orthodrive/drive/line/lane_path.hpp"
#include "orthodrive/drive/line/road_beside.hpp"
#include "orthodrive/geo/angle.hpp"
#include "orthodrive/math/cholesky.hpp"

namespace orthodrive {
namespace {

constexpr double shortest_wave_m = 15.0;
constexpr int axle_rounds = 3, wheel_rounds = 10, turn_rounds = 3;
constexpr double profile_reach_m = 2.5;  // a car feels the road over about its wheelbase
// What lines cost (bounded_line.hpp). Racing: curvature, and its change over less than 5 m so that it can be steered.
constexpr LineCosts racing_costs{.curvature_m4 = 1e4, .curvature_rate_m6 = 25e4};
LineCosts lane_costs(const LineOptions& options) {
  return {.offset = 1.0,
          .curvature_rate_m6 = std::pow(shortest_wave_m / (2.0 * std::numbers::pi), 6.0),
          .sharp_m4 = 1e5,
          .most_curvature_1pm = options.most_curvature_1pm};
}

/// Solves (I + weight D'D) p = q in place, D the third difference.
void smooth_open(std::vector<Vec2>& q, double weight) {
  const std::size_t n = q.size();
  if (n < 4) return;
  constexpr std::array<double, 4> d = {-1.0, 3.0, -3.0, 1.0};
  std::vector<double> entries(4 * n, 0.0), x, y;
  const SymmetricMatrix matrix = SymmetricMatrix::banded(entries, 3);
  for (std::size_t i = 0; i < n; ++i) matrix(i, i) = 1.0;
  for (std::size_t row = 0; row + 3 < n; ++row)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b <= a; ++b) matrix(row + a, row + b) += weight * d[a] * d[b];
  for (const Vec2 p : q) x.push_back(p.x), y.push_back(p.y);
  [[maybe_unused]] const bool definite = factorize(matrix);  // the identity makes it so
  assert(definite);
  solve_factored(matrix, x), solve_factored(matrix, y);
  for (std::size_t i = 0; i < n; ++i) q[i] = {x[i], y[i]};
}

/// The closed line is unrolled by so much at each end that the ends no longer matter in the middle.
void smooth(Polyline& line, bool closed, double step_m) {
  const double weight = std::pow(shortest_wave_m / (2.0 * std::numbers::pi * step_m), 6.0);
  const Vec2 origin = line.front();  // small numbers: UTM coordinates would cost digits
  for (Vec2& p : line) p = p - origin;
  if (closed) {
    const auto n = static_cast<std::ptrdiff_t>(line.size());
    const auto margin = static_cast<std::ptrdiff_t>(8.0 * shortest_wave_m / step_m);
    Polyline unrolled;
    for (std::ptrdiff_t i = -margin; i < n + margin; ++i)
      unrolled.push_back(line[static_cast<std::size_t>(((i % n) + n) % n)]);
    smooth_open(unrolled, weight);
    std::copy_n(unrolled.begin() + margin, n, line.begin());
  } else {
    smooth_open(line, weight);
  }
  for (Vec2& p : line) p = p + origin;
}

/// Heights and slopes from the road query; where the line runs off the road they go on as they were.
void sample_surface(DrivingLine& line, const roadquery::RoadQuery& query, double start_z_m) {
  roadquery::Cursor cursor;
  double z = start_z_m, gradient = 0.0, banking = 0.0, friction = 1.0;
  for (LinePoint& p : line.points) {
    if (const auto hit = query.find(p.x_m, p.y_m, z, cursor)) {
      const double c = std::cos(p.heading_rad), s = std::sin(p.heading_rad);
      z = hit->z;
      gradient = -(hit->normal[0] * c + hit->normal[1] * s) / hit->normal[2];
      banking = std::atan((hit->normal[0] * s - hit->normal[1] * c) / hit->normal[2]);
      friction = hit->friction;
    }
    p.z_m = z, p.gradient = gradient, p.banking = banking, p.friction = friction;
  }
}

/// From the heights a reach before and behind: second difference of the profile.
void add_vertical_curvature(DrivingLine& line) {
  const double length_m = line.length_m();
  std::vector<double> bend(line.points.size());
  for (std::size_t i = 0; i < bend.size(); ++i) {
    const double s = line.closed ? line.points[i].s_m
                                 : std::clamp(line.points[i].s_m, profile_reach_m,
                                              std::max(profile_reach_m, length_m - profile_reach_m));
    const double slope = line.at(s).gradient, rise = line.at(s + profile_reach_m).z_m - line.at(s).z_m,
                 fall = line.at(s).z_m - line.at(s - profile_reach_m).z_m;
    bend[i] = (rise - fall) / (profile_reach_m * profile_reach_m) / std::pow(1.0 + slope * slope, 1.5);
  }
  for (std::size_t i = 0; i < bend.size(); ++i) line.points[i].vertical_curvature_1pm = bend[i];
}

double start_z(const roadquery::RoadMap& map, const Route& route) {
  const RouteStep& first = route.steps.front();
  const roadquery::Road& road = map.roads[static_cast<std::size_t>(first.road)];
  return roadquery::elevation(road, first.forward ? 0.0 : road.length);
}

LineBetweenEdges racing_task(const LanePath& path, const Polyline& smooth, const DrivingLine& reference,
                             const LineOptions& options) {
  LineBetweenEdges task{.closed = path.closed, .reference = smooth};
  const std::vector<Vec2> normals = left_normals(smooth, path.closed);
  for (std::size_t i = 0; i < smooth.size(); ++i) {
    const double middle_m = dot(path.points[i] - smooth[i], normals[i]);
    bound(task, path.half_width_m[i] - middle_m, path.half_width_m[i] + middle_m, options,
          reference.points[i].curvature_1pm);
    task.wanted_m.push_back(0.0);
  }
  return task;
}

/// Without bounds yet.
LineBetweenEdges lane_task(const LanePath& path, const Polyline& smooth) {
  LineBetweenEdges task{.closed = path.closed, .reference = smooth};
  const std::vector<Vec2> normals = left_normals(smooth, path.closed);
  for (std::size_t i = 0; i < smooth.size(); ++i) task.wanted_m.push_back(dot(path.points[i] - smooth[i], normals[i]));
  return task;
}

/// Every point moved along its normal.
Polyline moved(const LineBetweenEdges& task, const std::vector<double>& offset) {
  const std::vector<Vec2> normals = left_normals(task.reference, task.closed);
  Polyline line(task.reference.size());
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = task.reference[i] + offset[i] * normals[i];
  return line;
}

double spacing_of(const LanePath& path) { return length_m(path.points) / static_cast<double>(path.points.size() - 1); }

}  // namespace

LinePoint DrivingLine::at(double s_m) const {
  const double total = length_m();
  double laps = 0.0;
  if (closed) {
    laps = std::floor(s_m / total);
    s_m -= laps * total;
  }
  const auto after = std::upper_bound(points.begin() + 1, points.end() - 1, s_m,
                                      [](double s, const LinePoint& p) { return s < p.s_m; });
  const LinePoint &a = *(after - 1), &b = *after;
  const double u = (s_m - a.s_m) / (b.s_m - a.s_m);
  const auto mix = [u](double p, double q) { return p + u * (q - p); };
  LinePoint p{s_m, mix(a.x_m, b.x_m), mix(a.y_m, b.y_m), mix(a.heading_rad, b.heading_rad)};
  // Beyond the ends of an open line only the position goes on.
  const double v = std::clamp(u, 0.0, 1.0);
  const auto hold = [v](double p0, double q0) { return p0 + v * (q0 - p0); };
  p.heading_rad = hold(a.heading_rad, b.heading_rad) + laps * (points.back().heading_rad - points.front().heading_rad);
  p.curvature_1pm = hold(a.curvature_1pm, b.curvature_1pm);
  p.z_m = hold(a.z_m, b.z_m), p.gradient = hold(a.gradient, b.gradient), p.banking = hold(a.banking, b.banking);
  p.vertical_curvature_1pm = hold(a.vertical_curvature_1pm, b.vertical_curvature_1pm);
  p.friction = hold(a.friction, b.friction), p.step = v < 0.5 ? a.step : b.step;
  return p;
}

/// Heading and curvature from the circle through each three points.
DrivingLine plain_line(const Polyline& line, bool closed, const std::vector<int>& step) {
  const std::size_t n = line.size(), count = closed ? n + 1 : n;
  DrivingLine result{closed, std::vector<LinePoint>(count)};
  double s = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    LinePoint& out = result.points[i];
    const Vec2 p = line[i % n];
    const Vec2 before = closed ? line[(i + n - 1) % n] : line[i > 0 ? i - 1 : 0];
    const Vec2 after = closed ? line[(i + 1) % n] : line[std::min(i + 1, n - 1)];
    if (i > 0) s += distance(p, line[i - 1]);
    out.s_m = s, out.x_m = p.x, out.y_m = p.y;
    out.heading_rad = std::atan2(after.y - before.y, after.x - before.x);
    if (i > 0) {
      const double last = result.points[i - 1].heading_rad;
      out.heading_rad = last + wrapped_angle(out.heading_rad - last);
    }
    out.curvature_1pm = curvature_of(before, p, after);
    if (!step.empty()) out.step = step[i % n];
  }
  if (!closed && n > 2) {
    result.points.front().curvature_1pm = result.points[1].curvature_1pm;
    result.points.back().curvature_1pm = result.points[n - 2].curvature_1pm;
  }
  return result;
}

DrivingLine line_through(const roadquery::RoadQuery& query, const std::vector<Vec2>& points, bool closed,
                         double start_z_m, const std::vector<int>& step) {
  DrivingLine line = plain_line(points, closed, step);
  sample_surface(line, query, start_z_m);
  add_vertical_curvature(line);
  return line;
}

namespace {

/// Follows the lanes, moved sideways from `reference` as far as the car needs.
DrivingLine line_beside(const roadquery::RoadQuery& query, const Route& route, const LanePath& path,
                        const Polyline& smoothed, const LineOptions& options) {
  const double z_m = start_z(query.map(), route);
  const DrivingLine reference = line_through(query, smoothed, path.closed, z_m);
  LineBetweenEdges task = lane_task(path, smoothed);
  const std::vector<Room> rooms = room_beside(query, reference, task.wanted_m);
  for (std::size_t i = 0; i < rooms.size(); ++i)
    bound(task, rooms[i].right_m, rooms[i].left_m, options, reference.points[i].curvature_1pm);
  const LineCosts costs = lane_costs(options);
  std::vector<double> offset = best_offsets(task, costs);
  DrivingLine line = line_through(query, moved(task, offset), path.closed, z_m, path.step);
  const auto improve = [&] {
    offset = best_offsets(task, costs);
    line = line_through(query, moved(task, offset), path.closed, z_m, path.step);
  };
  for (int round = 0; round < axle_rounds; ++round) bound_by_axles(task, rooms, line, options), improve();
  for (int round = 0; round < wheel_rounds; ++round) {
    const LineEnds ends = room_for_wheels(query.map(), route, line, options);
    if (!keep_wheels_on_road(task, offset, query, rooms, line, ends, options)) break;
    improve();
  }
  return line;
}

/// Largest mean of the curvature over a wheelbase.
double sharpest_1pm(const DrivingLine& line, double wheelbase_m) {
  double sharpest = 0.0;
  for (const LinePoint& p : line.points) {
    const double turn_rad =
        line.at(p.s_m + 0.5 * wheelbase_m).heading_rad - line.at(p.s_m - 0.5 * wheelbase_m).heading_rad;
    sharpest = std::max(sharpest, std::abs(turn_rad) / wheelbase_m);
  }
  return sharpest;
}

}  // namespace

DrivingLine make_driving_line(const roadquery::RoadQuery& query, const Route& route, const LineOptions& options) {
  const double z_m = start_z(query.map(), route);
  if (options.style == DrivingStyle::centre) {
    const LanePath centre = path_along_centre(query.map(), route);
    return line_through(query, centre.points, centre.closed, z_m, centre.step);
  }
  const bool racing = options.style == DrivingStyle::racing;
  const LanePath path = racing ? path_along_middle(query.map(), route) : path_along_lanes(query.map(), route);
  Polyline smoothed = path.points;
  smooth(smoothed, path.closed, spacing_of(path));
  if (racing) {
    const DrivingLine reference = line_through(query, smoothed, path.closed, z_m);
    const LineBetweenEdges task = racing_task(path, smoothed, reference, options);
    return line_through(query, moved(task, best_offsets(task, racing_costs)), path.closed, z_m, path.step);
  }
  DrivingLine line = line_beside(query, route, path, smoothed, options);
  for (int round = 0; round < turn_rounds; ++round) {
    const double sharpest = sharpest_1pm(line, options.wheelbase_m);
    if (sharpest <= options.most_curvature_1pm) break;
    for (std::size_t i = 0; i < smoothed.size(); ++i) smoothed[i] = {line.points[i].x_m, line.points[i].y_m};
    DrivingLine wider = line_beside(query, route, path, smoothed, options);
    if (sharpest_1pm(wider, options.wheelbase_m) >= sharpest) break;
    line = std::move(wider);
  }
  return line;
}

}  // namespace orthodrive
