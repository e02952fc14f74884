// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/heave.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "orthodrive/drive/line/axle_line.hpp"
#include "roadquery/surface/blend.hpp"
#include "vehicle/suspension.hpp"

namespace orthodrive {
namespace {

constexpr double step_s = 2e-3, slowest_mps = 1.0;

/// The body's share and the two wheels of an axle, all at rest at first.
class AxleMass {
 public:
  AxleMass(const vehicle::CarParameters& car, bool front, double road_m)
      : suspension_(front ? car.front : car.rear),
        tyre_(front ? car.front_tyre : car.rear_tyre),
        load_n_(0.5 * car.body.mass_kg * (front ? car.body.front_share : 1.0 - car.body.front_share) *
                vehicle::gravity_mps2),
        body_kg_(load_n_ / vehicle::gravity_mps2 - suspension_.unsprung_mass_kg),
        body_m_(road_m),
        hub_m_(road_m),
        road_m_(road_m) {}

  /// Moves on to where the road is that high; the acceleration of the body.
  double step(double road_m) {
    const double road_mps = (road_m - road_m_) / step_s;
    road_m_ = road_m;
    const double strut_n =
        vehicle::spring_n(suspension_, hub_m_ - body_m_) + vehicle::damper_n(suspension_, hub_mps_ - body_mps_);
    const double tyre_n =
        std::max(tyre_.vertical_npm * (road_m - hub_m_) + tyre_.vertical_nspm * (road_mps - hub_mps_), -load_n_);
    const double up_mps2 = strut_n / body_kg_;
    body_mps_ += step_s * up_mps2, hub_mps_ += step_s * (tyre_n - strut_n) / suspension_.unsprung_mass_kg;
    body_m_ += step_s * body_mps_, hub_m_ += step_s * hub_mps_;
    return up_mps2;
  }
  [[nodiscard]] double body_kg() const { return body_kg_; }

 private:
  const vehicle::Suspension& suspension_;
  const vehicle::Tyre& tyre_;
  double load_n_, body_kg_;  // of one wheel
  double body_m_, hub_m_, road_m_;
  double body_mps_ = 0.0, hub_mps_ = 0.0;
};

double height_at(const std::vector<double>& heights_m, double s_m) {
  const double place = std::clamp(s_m / AxleHeights::step_m, 0.0, static_cast<double>(heights_m.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(place), heights_m.size() - 2);
  return heights_m[i] + (place - static_cast<double>(i)) * (heights_m[i + 1] - heights_m[i]);
}

/// A wheel keeps its height where there is no road.
struct Wheel {
  double ahead_m = 0.0, left_m = 0.0, z_m = 0.0;
  roadquery::Cursor cursor;
};

}  // namespace

AxleHeights axle_heights(const roadquery::RoadQuery& query, const DrivingLine& line,
                         const vehicle::CarParameters& car) {
  const double half_m = 0.5 * car.body.wheelbase_m, z_m = line.points.front().z_m;
  std::array<Wheel, 4> wheels;
  for (std::size_t i = 0; i < 4; ++i) {
    const double track_m = (i < 2 ? car.front : car.rear).track_m;
    wheels[i].ahead_m = i < 2 ? half_m : -half_m, wheels[i].left_m = (i % 2 == 0 ? 0.5 : -0.5) * track_m;
    wheels[i].z_m = z_m + wheels[i].ahead_m * line.points.front().gradient;
  }
  const std::vector<double> heading = car_headings(line, car.body.wheelbase_m);
  AxleHeights heights;
  std::size_t i = 0;
  const auto count = static_cast<std::size_t>(std::floor(line.length_m() / AxleHeights::step_m)) + 2;
  for (std::size_t n = 0; n < count; ++n) {
    const double s_m = std::min(static_cast<double>(n) * AxleHeights::step_m, line.length_m());
    while (i + 2 < line.points.size() && line.points[i + 1].s_m <= s_m) ++i;
    const LinePoint p = line.at(s_m);
    const double u = (s_m - line.points[i].s_m) / (line.points[i + 1].s_m - line.points[i].s_m);
    const double psi = heading[i] + u * (heading[i + 1] - heading[i]), c = std::cos(psi), s = std::sin(psi);
    for (Wheel& wheel : wheels) {
      const double x = p.x_m + c * wheel.ahead_m - s * wheel.left_m, y = p.y_m + s * wheel.ahead_m + c * wheel.left_m;
      const auto hit = query.find(x, y, wheel.z_m, wheel.cursor);
      if (hit && roadquery::is_same_level(hit->z, wheel.z_m)) wheel.z_m = hit->z;
    }
    heights.front_m.push_back(0.5 * (wheels[0].z_m + wheels[1].z_m));
    heights.rear_m.push_back(0.5 * (wheels[2].z_m + wheels[3].z_m));
  }
  return heights;
}

std::vector<double> heave_mps2(const DrivingLine& line, const AxleHeights& heights,
                               const std::vector<double>& speed_mps, const vehicle::CarParameters& car) {
  const auto& p = line.points;
  std::vector<double> most(p.size(), 0.0);
  if (p.size() < 2) return most;
  AxleMass front(car, true, heights.front_m.front()), rear(car, false, heights.rear_m.front());
  const double front_share = front.body_kg() / (front.body_kg() + rear.body_kg());
  std::size_t i = 0;
  for (double s_m = 0.0; s_m < line.length_m();) {
    while (i + 2 < p.size() && p[i + 1].s_m <= s_m) ++i;
    const double u = (s_m - p[i].s_m) / (p[i + 1].s_m - p[i].s_m);
    const double v = std::max(speed_mps[i] + u * (speed_mps[i + 1] - speed_mps[i]), slowest_mps);
    s_m += step_s * v;
    const double up_mps2 = front_share * front.step(height_at(heights.front_m, s_m)) +
                           (1.0 - front_share) * rear.step(height_at(heights.rear_m, s_m));
    most[i] = std::max(most[i], std::abs(up_mps2)), most[i + 1] = std::max(most[i + 1], std::abs(up_mps2));
  }
  return most;
}

}  // namespace orthodrive
