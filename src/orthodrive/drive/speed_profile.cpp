#include "orthodrive/drive/speed_profile.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {

/// What banking leaves of the lateral acceleration: the outer side higher helps.
double lateral_limit_mps2(const LinePoint& p, const Driver& driver) {
  const double along_road = gravity_mps2 * std::sin(p.banking);  // pulls to the right when the left side is higher
  return std::max(driver.max_lateral_mps2 - std::copysign(along_road, p.curvature_1pm * p.banking), 0.5);
}

double curve_speed_mps(const LinePoint& p, const Driver& driver) {
  const double k = std::abs(p.curvature_1pm);
  const double limit = lateral_limit_mps2(p, driver);
  return k * driver.max_speed_mps * driver.max_speed_mps > limit ? std::sqrt(limit / k) : driver.max_speed_mps;
}

/// Share of the longitudinal limit that cornering leaves (friction ellipse); a tenth remains at the limit.
double ellipse_share(const LinePoint& p, double speed_mps, const Driver& driver) {
  const double used = speed_mps * speed_mps * std::abs(p.curvature_1pm) / lateral_limit_mps2(p, driver);
  return std::max(std::sqrt(std::max(1.0 - used * used, 0.0)), 0.1);
}

double faster(double speed_mps, double acceleration_mps2, double way_m) {
  return std::sqrt(std::max(speed_mps * speed_mps + 2.0 * acceleration_mps2 * way_m, crawl_mps * crawl_mps));
}

}  // namespace

double resistance_mps2(const Vehicle& vehicle, double speed_mps) {
  const double drag_n = 0.5 * air_density_kgpm3 * vehicle.drag_area_m2 * speed_mps * speed_mps;
  return vehicle.rolling_resistance * gravity_mps2 + drag_n / vehicle.mass_kg;
}

double engine_mps2(const Vehicle& vehicle, double speed_mps) {
  return std::min(vehicle.max_drive_force_n, vehicle.max_power_w / std::max(speed_mps, 1.0)) / vehicle.mass_kg;
}

std::vector<double> plan_speed(const DrivingLine& line, const Vehicle& vehicle, const Driver& driver) {
  const auto& points = line.points;
  const std::size_t n = points.size();
  std::vector<double> speed(n);
  for (std::size_t i = 0; i < n; ++i) speed[i] = std::max(curve_speed_mps(points[i], driver), crawl_mps);
  if (!line.closed) speed.front() = speed.back() = crawl_mps;

  // On a closed line the second round starts with what the first one ended with: the first and last point are one.
  for (int round = 0; round < (line.closed ? 2 : 1); ++round) {
    if (line.closed) speed.back() = speed.front() = std::min(speed.front(), speed.back());
    for (std::size_t i = n - 1; i-- > 0;) {
      const LinePoint& p = points[i + 1];
      const double way_m = p.s_m - points[i].s_m;
      const double brake = driver.max_brake_mps2 * ellipse_share(p, speed[i + 1], driver) +
                           resistance_mps2(vehicle, speed[i + 1]) + gravity_mps2 * std::sin(std::atan(p.gradient));
      speed[i] = std::min(speed[i], faster(speed[i + 1], brake, way_m));
    }
    if (line.closed) speed.back() = speed.front() = std::min(speed.front(), speed.back());
    for (std::size_t i = 1; i < n; ++i) {
      const LinePoint& p = points[i - 1];
      const double way_m = points[i].s_m - p.s_m;
      const double pull = std::min(engine_mps2(vehicle, speed[i - 1]) - resistance_mps2(vehicle, speed[i - 1]) -
                                       gravity_mps2 * std::sin(std::atan(p.gradient)),
                                   driver.max_drive_mps2 * ellipse_share(p, speed[i - 1], driver));
      speed[i] = std::min(speed[i], faster(speed[i - 1], pull, way_m));
    }
  }
  return speed;
}

}  // namespace orthodrive
