// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/steering_limits.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/drive/car/speed_profile.hpp"
#include "orthodrive/drive/line/axle_line.hpp"

namespace orthodrive {
namespace {

constexpr double steering_share = 0.5;  // of its rate; the rest is left to correct with
constexpr double stop_share = 0.97;     // of the steering's stop; the rest is left to correct with
constexpr double near_stop_share = 0.8, slowest_steering_mps = 2.0;
constexpr double runs_wide = 1.03;  // so much over full lock a bend of a radius of 4 m is left by less than 0.2 m

}  // namespace

double full_lock_curvature_1pm(const vehicle::CarParameters& car) {
  const double wheelbase_m = car.body.wheelbase_m;
  return 1.0 / std::hypot(wheelbase_m / std::tan(car.steering.max_wheel_rad), 0.5 * wheelbase_m);
}

void slow_down_to_steer(const vehicle::CarParameters& car, const EnvelopeTable& envelope, const DrivingLine& line,
                        double max_lateral_mps2, std::vector<double>& legal_mps) {
  const std::vector<double> heading = car_headings(line, car.body.wheelbase_m);
  const DrivingLine front = front_axle_line(line, car.body.wheelbase_m, heading);
  const std::vector<double> angle = steering_angles(front, heading);
  const double rate_radps = steering_share * car.steering.max_wheel_rate_radps;
  const auto &p = line.points, &f = front.points;
  for (std::size_t i = 1; i < angle.size(); ++i) {
    const double way_m = p[i].s_m - p[i - 1].s_m;
    const double turn_1pm = std::abs(angle[i] - angle[i - 1]) / way_m;
    for (double* legal : {&legal_mps[i - 1], &legal_mps[i]})
      if (turn_1pm * *legal > rate_radps) *legal = rate_radps / turn_1pm;
    // While the steering turns, the front axle's way bends more than the middle's, and it is longer.
    const double faster = (f[i].s_m - f[i - 1].s_m) / way_m;
    LinePoint axle = p[i];
    axle.curvature_1pm = f[i].curvature_1pm * faster * faster;
    const double by_bank_mps2 = std::copysign(road_load(axle, 0.0).lateral_mps2, axle.curvature_1pm * axle.banking);
    const double by_turn_1pm = std::abs(road_load(axle, 1.0).lateral_mps2 - road_load(axle, 0.0).lateral_mps2);
    const double left_mps2 = max_lateral_mps2 - by_bank_mps2;
    if (left_mps2 > 0.0 && by_turn_1pm * legal_mps[i] * legal_mps[i] > left_mps2)
      legal_mps[i] = std::sqrt(left_mps2 / by_turn_1pm);
    // Near the stop the front tyres' slip, beyond that of the rear, is missing to the bend.
    const auto beyond_stop = [&](double speed_mps) {
      const double front = by_turn_1pm * speed_mps * speed_mps / vehicle::gravity_mps2 / std::cos(angle[i]);
      const double rear = std::abs(road_load(p[i], speed_mps).lateral_mps2) / vehicle::gravity_mps2;
      return std::abs(angle[i]) + envelope.front_slip().angle_rad(front) - envelope.rear_slip().angle_rad(rear) >
             stop_share * car.steering.max_wheel_rad;
    };
    const bool near_stop = std::abs(angle[i]) > near_stop_share * car.steering.max_wheel_rad;
    while (near_stop && legal_mps[i] > slowest_steering_mps && beyond_stop(legal_mps[i])) legal_mps[i] *= 0.95;
  }
}

std::optional<TightBend> first_too_tight(const vehicle::CarParameters& car, const DrivingLine& line) {
  const double half_m = 0.5 * car.body.wheelbase_m, most_1pm = runs_wide * full_lock_curvature_1pm(car);
  std::optional<TightBend> bend;
  for (const LinePoint& p : line.points) {
    if (!line.closed && (p.s_m < half_m || p.s_m > line.length_m() - half_m)) continue;
    const double turn_rad = line.at(p.s_m + half_m).heading_rad - line.at(p.s_m - half_m).heading_rad;
    const double mean_1pm = std::abs(turn_rad) / (2.0 * half_m);
    if (mean_1pm > most_1pm) {
      if (!bend) bend = TightBend{p.s_m, p.x_m, p.y_m};
      bend->curvature_1pm = std::max(bend->curvature_1pm, mean_1pm), bend->step = p.step;
    } else if (bend) {
      break;
    }
  }
  return bend;
}

}  // namespace orthodrive
