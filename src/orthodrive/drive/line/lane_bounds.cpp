// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/lane_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "orthodrive/drive/line/axle_line.hpp"

namespace orthodrive {
namespace {

constexpr double tight_margin_m = 0.05;  // kept free where the car can hardly turn or hardly fits
constexpr double tight_reach_m = 15.0;   // a driver prepares for such a place, and comes out of it, over so much

/// Half the car with what its wheels stray from the line in a bend, inwards and outwards: with the middle of the
/// wheelbase on a circle, the rear axle runs wheelbase^2 / 8 R within and the front axle three times that without.
struct CarRoom {
  double inner_m = 0.0, outer_m = 0.0;
};
CarRoom car_room(const LineOptions& options, double curvature_1pm) {
  const double stray_m = std::min(options.wheelbase_m * options.wheelbase_m * std::abs(curvature_1pm) / 8.0, 0.4);
  const double half_m = 0.5 * options.car_width_m + options.margin_m;
  return {half_m + stray_m, half_m + 3.0 * stray_m};
}

/// Where the road is narrower than the car and what is kept free beside it the car takes the middle; a line needs a
/// little room to be smooth in. Where not even the car fits one side of it stays on the road.
std::pair<double, double> in_order(double lower, double upper, double margin_m) {
  if (lower <= upper) return {lower, upper};
  if (lower - upper > 2.0 * margin_m) return {upper, lower};
  return {0.5 * (lower + upper) - tight_margin_m, 0.5 * (lower + upper) + tight_margin_m};
}

/// Kept free beside the car at every point of the line. Before a narrow place one does not keep to one side.
std::vector<double> margins(const DrivingLine& line, const std::vector<Room>& rooms, const LineOptions& options) {
  const auto& p = line.points;
  std::vector<double> margin_m(p.size(), options.margin_m);
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const bool narrow = rooms[i].left_m + rooms[i].right_m < options.car_width_m + 2.0 * options.margin_m;
    if (!narrow && std::abs(p[i].curvature_1pm) <= options.most_curvature_1pm) continue;
    const auto tighten = [&](std::size_t k) { margin_m[k] = std::min(margin_m[k], tight_margin_m); };
    for (std::size_t k = i; k < p.size() && p[k].s_m < p[i].s_m + tight_reach_m; ++k) tighten(k);
    for (std::size_t k = i + 1; k > 0 && p[k - 1].s_m > p[i].s_m - tight_reach_m; --k) tighten(k - 1);
  }
  return margin_m;
}

/// How far a wheel beside a place of its axle stands from the road, towards the axle; 0: on it. `rise_m`: of the road
/// from the axle's place, at height `z_m`, to the wheel.
double off_road_m(const roadquery::RoadQuery& query, Vec2 axle, Vec2 to_wheel, double z_m, double rise_m) {
  constexpr double step_m = 0.05;
  roadquery::Cursor cursor;
  const double half_m = length(to_wheel);
  for (double off_m = 0.0; off_m < half_m; off_m += step_m) {
    const double share = 1.0 - off_m / half_m;
    const Vec2 at = axle + share * to_wheel;
    if (place_for_car(query, at.x, at.y, z_m + share * rise_m, cursor)) return off_m;
  }
  return 0.0;  // the axle itself is beside the road: nothing to be told from
}

}  // namespace

void bound(LineBetweenEdges& task, double right_m, double left_m, const LineOptions& options, double curvature_1pm) {
  const CarRoom room = car_room(options, curvature_1pm);
  const double to_left = curvature_1pm > 0.0 ? room.inner_m : room.outer_m;
  const double to_right = curvature_1pm > 0.0 ? room.outer_m : room.inner_m;
  const auto [lower, upper] = in_order(to_right - right_m, left_m - to_left, options.margin_m);
  task.lower_m.push_back(lower), task.upper_m.push_back(upper);
}

void bound_by_axles(LineBetweenEdges& task, const std::vector<Room>& rooms, const DrivingLine& line,
                    const LineOptions& options) {
  const AxleStrays stray = axle_strays(line, options.wheelbase_m, car_headings(line, options.wheelbase_m));
  const std::vector<double> margin_m = margins(line, rooms, options);
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const double half_m = 0.5 * options.car_width_m + margin_m[i];
    std::tie(task.lower_m[i], task.upper_m[i]) =
        in_order(half_m - std::min(stray.front_m[i], stray.rear_m[i]) - rooms[i].right_m,
                 rooms[i].left_m - half_m - std::max(stray.front_m[i], stray.rear_m[i]), margin_m[i]);
  }
}

bool keep_wheels_on_road(LineBetweenEdges& task, const std::vector<double>& offset, const roadquery::RoadQuery& query,
                         const std::vector<Room>& rooms, const DrivingLine& line, LineEnds ends,
                         const LineOptions& options) {
  constexpr std::ptrdiff_t around = 2;  // points to both sides that move along
  constexpr int looks = 4;              // from one point to the next: asphalt has notches
  const std::vector<double> heading = car_headings(line, options.wheelbase_m);
  const auto n = static_cast<std::ptrdiff_t>(offset.size());
  const double half_base_m = 0.5 * options.wheelbase_m;
  const std::vector<double> margin_m = margins(line, rooms, options);
  std::vector<double> push(offset.size(), 0.0);  // to the left, m
  for (std::ptrdiff_t look = 0; look < looks * (task.closed ? n : n - 1); ++look) {
    const auto i = static_cast<std::size_t>(look / looks);
    const double u = static_cast<double>(look % looks) / looks;
    const LinePoint p = line.at(line.points[i].s_m + u * (line.points[i + 1].s_m - line.points[i].s_m));
    if (!task.closed && (p.s_m < ends.from_m || p.s_m > ends.to_m)) continue;
    const double psi = heading[i] + u * (heading[i + 1] - heading[i]);
    const Vec2 ahead{std::cos(psi), std::sin(psi)}, left = left_normal(ahead);
    const double half_car_m = 0.5 * (options.car_width_m + margin_m[i]);
    for (const double axle_m : {half_base_m, -half_base_m}) {
      const Vec2 axle = Vec2{p.x_m, p.y_m} + axle_m * ahead;
      const double z_m = p.z_m + axle_m * p.gradient;
      const double rise_m = half_car_m * std::tan(p.banking);
      const double need = off_road_m(query, axle, -half_car_m * left, z_m, -rise_m) -
                          off_road_m(query, axle, half_car_m * left, z_m, rise_m);
      if (need == 0.0) continue;
      const auto middle = static_cast<std::ptrdiff_t>(i) + static_cast<std::ptrdiff_t>(std::lround(axle_m));
      for (std::ptrdiff_t k = middle - around; k <= middle + around; ++k) {
        if (!task.closed && (k < 0 || k >= n)) continue;
        double& most = push[static_cast<std::size_t>(((k % n) + n) % n)];
        if (std::abs(need) > std::abs(most)) most = need;
      }
    }
  }
  bool moves = false;
  for (std::size_t i = 0; i < push.size(); ++i) {
    if (push[i] == 0.0) continue;
    moves = true;
    const double wanted = offset[i] + push[i];
    (push[i] > 0.0 ? task.lower_m[i] : task.upper_m[i]) = wanted;
    // Narrower than the car: as near as the other side lets it.
    if (task.lower_m[i] > task.upper_m[i])
      task.lower_m[i] = task.upper_m[i] = 0.5 * (task.lower_m[i] + task.upper_m[i]);
  }
  return moves;
}

}  // namespace orthodrive
