// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/axle_line.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/geo/angle.hpp"

namespace orthodrive {
namespace {

constexpr double fine_step_m = 0.1;

/// Heading at the end of a piece of the line that it has at its beginning.
double follow_axle(double heading_rad, const LinePoint& a, const LinePoint& b, double slip_a, double slip_b,
                   double wheelbase_m) {
  const int steps = std::max(1, static_cast<int>(std::ceil((b.s_m - a.s_m) / fine_step_m)));
  const double ds_m = (b.s_m - a.s_m) / steps;
  for (int k = 0; k < steps; ++k) {
    const double u = (k + 0.5) / steps;
    const double way_rad = a.heading_rad + u * (b.heading_rad - a.heading_rad), slip = slip_a + u * (slip_b - slip_a);
    const double half = heading_rad + 0.5 * ds_m * 2.0 / wheelbase_m * (std::sin(way_rad - heading_rad) + slip);
    heading_rad += ds_m * 2.0 / wheelbase_m * (std::sin(way_rad - half) + slip);
  }
  return heading_rad;
}

/// How far an axle so far ahead of the middle is to the left of the line when it passes each of its points.
std::vector<double> stray(const DrivingLine& line, double ahead_m, const std::vector<double>& car_heading_rad) {
  constexpr int newton_steps = 3;  // the line is nearly straight over one
  const std::size_t n = line.points.size();
  std::vector<double> s_m(n), left_m(n), result(n);
  for (std::size_t i = 0; i < n; ++i) {
    const LinePoint& p = line.points[i];
    const double x = p.x_m + ahead_m * std::cos(car_heading_rad[i]), y = p.y_m + ahead_m * std::sin(car_heading_rad[i]);
    s_m[i] = p.s_m + ahead_m;
    for (int k = 0; k < newton_steps; ++k) {
      const LinePoint q = line.at(s_m[i]);
      const double c = std::cos(q.heading_rad), s = std::sin(q.heading_rad), dx = x - q.x_m, dy = y - q.y_m;
      left_m[i] = dy * c - dx * s;
      s_m[i] += dx * c + dy * s;
    }
  }
  std::size_t after = 1;
  for (std::size_t i = 0; i < n && n > 1; ++i) {
    while (after + 1 < n && s_m[after] < line.points[i].s_m) ++after;
    const double way_m = s_m[after] - s_m[after - 1];
    const double u = way_m > 0.0 ? std::clamp((line.points[i].s_m - s_m[after - 1]) / way_m, 0.0, 1.0) : 0.0;
    result[i] = left_m[after - 1] + u * (left_m[after] - left_m[after - 1]);
  }
  return result;
}

}  // namespace

AxleStrays axle_strays(const DrivingLine& line, double wheelbase_m, const std::vector<double>& car_heading_rad) {
  return {stray(line, 0.5 * wheelbase_m, car_heading_rad), stray(line, -0.5 * wheelbase_m, car_heading_rad)};
}

std::vector<double> car_headings(const DrivingLine& line, double wheelbase_m,
                                 const std::vector<double>& rear_slip_rad) {
  const auto& p = line.points;
  const auto slip = [&](std::size_t i) { return rear_slip_rad.empty() ? 0.0 : rear_slip_rad[i]; };
  std::vector<double> heading(p.size());
  if (p.empty()) return heading;
  heading.front() = p.front().heading_rad;
  // Round a closed line twice: what it began with is forgotten over a few wheelbases.
  for (int round = 0; round < (line.closed ? 2 : 1); ++round) {
    if (round > 0) heading.front() = heading.back() - (p.back().heading_rad - p.front().heading_rad);
    for (std::size_t i = 1; i < p.size(); ++i)
      heading[i] = follow_axle(heading[i - 1], p[i - 1], p[i], slip(i - 1), slip(i), wheelbase_m);
  }
  return heading;
}

DrivingLine front_axle_line(const DrivingLine& line, double wheelbase_m, const std::vector<double>& car_heading_rad) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < line.points.size(); ++i) {
    const LinePoint& p = line.points[i];
    points.push_back({p.x_m + 0.5 * wheelbase_m * std::cos(car_heading_rad[i]),
                      p.y_m + 0.5 * wheelbase_m * std::sin(car_heading_rad[i])});
  }
  if (line.closed) points.pop_back();
  return plain_line(points, line.closed);
}

std::vector<double> steering_angles(const DrivingLine& front, const std::vector<double>& car_heading_rad) {
  std::vector<double> angle(car_heading_rad.size());
  for (std::size_t i = 0; i < angle.size(); ++i)
    angle[i] = wrapped_angle(front.points[i].heading_rad - car_heading_rad[i]);
  return angle;
}

}  // namespace orthodrive
