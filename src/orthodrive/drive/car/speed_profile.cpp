// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/speed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "roadquery/roads/speed_limits.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using vehicle::gravity_mps2;

constexpr double scan_mps = 2.0, tolerance_mps = 0.01;
constexpr double bumper_m = 3.0;     // from the middle of the car to where its front should stay before a junction
constexpr double crawl_mps = 2.0;    // the slowest that is planned but at stops; open lines end with it
constexpr double gently_mps2 = 0.5;  // up to grip_share
constexpr double least_length_m = 1e-6;
constexpr double fastest_on_bank_mps = 100.0;  // beyond it nothing is looked for

/// Of the car where it takes that share of its lateral limit.
vehicle::EnvelopeQuery query_of(const LinePoint& p, double speed_mps, const RoadLoad& load, double share) {
  return {speed_mps, load.normal_mps2, load.lateral_mps2 / share, p.friction};
}

/// Which of a driver's limits hold: where a bank is so steep that no speed is within all of them, fewer do.
enum class Within { all, lateral_and_grip, grip };

/// The car's limits at a place, with what the driver leaves of them.
class Limits {
 public:
  Limits(const EnvelopeTable& envelope, const Driver& driver) : envelope_(envelope), driver_(driver) {}

  [[nodiscard]] bool can_corner(const LinePoint& p, double speed_mps, Within within = Within::all) const {
    const RoadLoad load = road_load(p, speed_mps);
    if (within == Within::all && std::abs(load.normal_mps2 - gravity_mps2) > driver_.max_vertical_mps2) return false;
    if (within != Within::grip && std::abs(load.lateral_mps2) > driver_.max_lateral_mps2) return false;
    return std::abs(load.lateral_mps2) <= driver_.grip_share * able_mps2(p, speed_mps, load);
  }
  /// Largest speed in the bend up to which every speed is possible; of a bank that is too steep for low speeds, the
  /// upper end of the lowest speeds that are.
  [[nodiscard]] double corner_mps(const LinePoint& p, double most_mps) const {
    if (!is_too_steep_to_stand(p)) return band_end_mps(p, 0.0, most_mps, Within::all);
    for (const Within within : {Within::all, Within::lateral_and_grip, Within::grip})
      if (const auto from_mps = band_begin_mps(p, most_mps, within))
        return band_end_mps(p, *from_mps, most_mps, within);
    return 0.0;
  }
  /// Lowest speed up to `most_mps` at which the car stays on the bank; none: it slides down at all of them.
  [[nodiscard]] std::optional<double> hold_mps(const LinePoint& p, double most_mps) const {
    return band_begin_mps(p, most_mps, Within::grip);
  }
  /// Whether the tyres, with all their grip, cannot hold the car against the bank.
  [[nodiscard]] bool slides_down(const LinePoint& p, double speed_mps) const {
    const RoadLoad load = road_load(p, speed_mps);
    return load.lateral_mps2 * p.banking > 0.0 && std::abs(load.lateral_mps2) > able_mps2(p, speed_mps, load);
  }
  /// Deceleration (positive) on the brakes, with the slope.
  [[nodiscard]] double brake_mps2(const LinePoint& p, double speed_mps) const {
    const RoadLoad load = road_load(p, speed_mps);
    const double grip = driver_.grip_share * envelope_.max_brake_mps2(query_of(p, speed_mps, load, driver_.grip_share));
    return std::min(grip + load.slope_mps2, driver_.max_brake_mps2);
  }
  [[nodiscard]] double drive_mps2(const LinePoint& p, double speed_mps) const {
    return most_drive_mps2(envelope_, driver_, p, speed_mps);
  }

 private:
  [[nodiscard]] double able_mps2(const LinePoint& p, double speed_mps, const RoadLoad& load) const {
    return envelope_.max_lateral_mps2({speed_mps, load.normal_mps2, load.lateral_mps2, p.friction});
  }
  [[nodiscard]] bool is_too_steep_to_stand(const LinePoint& p) const {
    const RoadLoad load = road_load(p, 0.0);
    return std::abs(load.lateral_mps2) >
           std::min(driver_.max_lateral_mps2, driver_.grip_share * able_mps2(p, 0.0, load));
  }
  /// From a speed that is possible up to the first that is not.
  [[nodiscard]] double band_end_mps(const LinePoint& p, double from_mps, double most_mps, Within within) const {
    double low = from_mps, high = from_mps;
    while (high < most_mps) {
      high = std::min(high + scan_mps, most_mps);
      if (!can_corner(p, high, within)) break;
      low = high;
    }
    while (high - low > tolerance_mps) {
      const double middle = 0.5 * (low + high);
      (can_corner(p, middle, within) ? low : high) = middle;
    }
    return low;
  }
  /// The lowest possible speed, where the lowest speeds are not.
  [[nodiscard]] std::optional<double> band_begin_mps(const LinePoint& p, double most_mps, Within within) const {
    const double end_mps = std::min(most_mps, fastest_on_bank_mps);
    double low = 0.0, high = 0.0;
    while (!can_corner(p, high, within)) {
      if (high >= end_mps) return std::nullopt;
      low = high, high = std::min(high + scan_mps, end_mps);
    }
    while (high - low > tolerance_mps) {
      const double middle = 0.5 * (low + high);
      (can_corner(p, middle, within) ? high : low) = middle;
    }
    return high;
  }

  const EnvelopeTable& envelope_;
  const Driver& driver_;
};

/// Length of the way between two points, with the slope.
double way_m(const LinePoint& a, const LinePoint& b) {
  return std::max((b.s_m - a.s_m) * std::hypot(1.0, 0.5 * (a.gradient + b.gradient)), least_length_m);
}

double faster(double speed_mps, double acceleration_mps2, double way_m) {
  return std::sqrt(std::max(speed_mps * speed_mps + 2.0 * acceleration_mps2 * way_m, 0.0));
}

/// Of the driving lane that is driven on; beside driving lanes of those in one's direction.
double limit_on(const roadquery::Road& road, const roadquery::Hit& hit, bool forward) {
  const roadquery::LaneSection& section = roadquery::section_at(road, hit.s);
  for (const roadquery::Lane& lane : hit.lane_id > 0 ? section.left : section.right)
    if (lane.id == hit.lane_id && lane.type == roadquery::LaneType::driving)
      return roadquery::lane_limit_mps(road, hit.lane_id, hit.s);
  const bool on_right = forward == (road.driving_side == roadquery::DrivingSide::right);
  return roadquery::fastest_limit_mps(road, hit.s, on_right ? roadquery::LimitSide::right : roadquery::LimitSide::left);
}

void stop_at(const DrivingLine& line, double s_m, std::vector<double>& speed) {
  const auto& p = line.points;
  const auto after = std::lower_bound(p.begin(), p.end(), s_m, [](const LinePoint& q, double s) { return q.s_m < s; });
  speed[static_cast<std::size_t>(std::min(after, p.end() - 1) - p.begin())] = 0.0;
}

}  // namespace

RoadLoad road_load(const LinePoint& p, double speed_mps) {
  const double slope = std::atan(p.gradient), v2 = speed_mps * speed_mps;
  const double c = std::cos(slope), cos_bank = std::cos(p.banking), sin_bank = std::sin(p.banking);
  const double turn_mps2 = v2 * c * c * p.curvature_1pm;  // horizontal, to the left
  return {turn_mps2 * cos_bank + gravity_mps2 * c * sin_bank,
          gravity_mps2 * c * cos_bank - turn_mps2 * sin_bank + v2 * p.vertical_curvature_1pm,
          gravity_mps2 * std::sin(slope)};
}

double most_drive_mps2(const EnvelopeTable& envelope, const Driver& driver, const LinePoint& p, double speed_mps) {
  const RoadLoad load = road_load(p, speed_mps);
  const auto with = [&](double share) {
    return envelope.max_drive_mps2(query_of(p, speed_mps, load, share), load.slope_mps2) - load.slope_mps2;
  };
  double most = with(driver.exit_share);
  if (most < gently_mps2) most = std::max(most, std::min(with(driver.grip_share), gently_mps2));
  return std::min(most, driver.max_drive_mps2);
}

std::vector<double> plan_speed(const DrivingLine& line, const EnvelopeTable& envelope, const Driver& driver,
                               const SpeedCaps& caps) {
  const auto& points = line.points;
  const std::size_t n = points.size();
  const Limits limits(envelope, driver);
  std::vector<double> speed(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double legal = caps.legal_mps.empty() ? driver.max_speed_mps : caps.legal_mps[i];
    speed[i] = std::max(limits.corner_mps(points[i], std::min(legal, driver.max_speed_mps)), crawl_mps);
  }
  for (const double stop_m : caps.stops_m) stop_at(line, stop_m, speed);
  if (!line.closed) speed.front() = 0.0, speed.back() = std::min(speed.back(), crawl_mps);

  // On a closed line the second round starts with what the first one ended with: the first and last point are one.
  for (int round = 0; round < (line.closed ? 2 : 1); ++round) {
    if (line.closed) speed.back() = speed.front() = std::min(speed.front(), speed.back());
    for (std::size_t i = n - 1; i-- > 0;) {
      const double brake = limits.brake_mps2(points[i + 1], speed[i + 1]);
      speed[i] = std::min(speed[i], faster(speed[i + 1], brake, way_m(points[i], points[i + 1])));
    }
    if (line.closed) speed.back() = speed.front() = std::min(speed.front(), speed.back());
    for (std::size_t i = 1; i < n; ++i) {
      const double drive = limits.drive_mps2(points[i - 1], speed[i - 1]);
      speed[i] = std::min(speed[i], faster(speed[i - 1], drive, way_m(points[i - 1], points[i])));
    }
  }
  return speed;
}

std::vector<double> least_speeds_on_banks(const DrivingLine& line, const EnvelopeTable& envelope,
                                          const Driver& driver) {
  const Limits limits(envelope, driver);
  std::vector<double> least_mps;
  least_mps.reserve(line.points.size());
  for (const LinePoint& p : line.points) least_mps.push_back(limits.hold_mps(p, fastest_on_bank_mps).value_or(0.0));
  return least_mps;
}

std::optional<SteepBank> first_too_steep_bank(const DrivingLine& line, const EnvelopeTable& envelope,
                                              const Driver& driver, const std::vector<double>& speed_mps) {
  const Limits limits(envelope, driver);
  for (std::size_t i = 0; i < speed_mps.size(); ++i)
    if (limits.slides_down(line.points[i], speed_mps[i]))
      return SteepBank{i, limits.hold_mps(line.points[i], fastest_on_bank_mps)};
  return std::nullopt;
}

std::vector<double> legal_speeds(const roadquery::RoadQuery& query, const Route& route, const DrivingLine& line) {
  const roadquery::RoadMap& map = query.map();
  std::vector<double> legal;
  legal.reserve(line.points.size());
  roadquery::Cursor cursor;
  for (const LinePoint& p : line.points) {
    const RouteStep& step = route.steps[static_cast<std::size_t>(p.step)];
    const roadquery::Road& road = map.roads[static_cast<std::size_t>(step.road)];
    double limit = road.speed_limit_mps;
    if (has_lane_limits(road)) {
      if (cursor.road != step.road) cursor = {step.road, step.forward ? 0.0 : road.length};
      const auto hit = query.find(p.x_m, p.y_m, p.z_m, cursor, roadquery::hit_position);
      if (hit && hit->road == step.road) limit = limit_on(road, *hit, step.forward);
    }
    legal.push_back(limit > 0.0 ? limit : std::numeric_limits<double>::infinity());
  }
  return legal;
}

std::vector<double> give_way_places(const roadquery::RoadMap& map, const Route& route, const DrivingLine& line) {
  const auto must_wait = [&](int step) {
    const roadquery::Road& road = map.roads[static_cast<std::size_t>(route.steps[static_cast<std::size_t>(step)].road)];
    for (const roadquery::Junction& junction : map.junctions) {
      if (junction.id != road.junction) continue;
      return std::any_of(junction.priorities.begin(), junction.priorities.end(),
                         [&](const roadquery::Priority& priority) { return priority.low == road.id; });
    }
    return false;
  };
  std::vector<double> places;
  for (std::size_t i = 1; i < line.points.size(); ++i) {
    const LinePoint &a = line.points[i - 1], &b = line.points[i];
    if (a.step == b.step || !must_wait(b.step)) continue;
    if (b.s_m - bumper_m > (places.empty() ? bumper_m : places.back() + bumper_m)) places.push_back(b.s_m - bumper_m);
  }
  return places;
}

SpeedPlan::At SpeedPlan::at(double s_m) const {
  const auto& p = line_->points;
  if (line_->closed) s_m -= std::floor(s_m / line_->length_m()) * line_->length_m();
  const auto after =
      std::upper_bound(p.begin() + 1, p.end() - 1, s_m, [](double s, const LinePoint& q) { return s < q.s_m; });
  const auto i = static_cast<std::size_t>(after - p.begin());
  const double way = way_m(p[i - 1], p[i]);
  const double u = std::clamp((s_m - p[i - 1].s_m) / std::max(p[i].s_m - p[i - 1].s_m, least_length_m), 0.0, 1.0);
  const double a2 = speed_[i - 1] * speed_[i - 1], b2 = speed_[i] * speed_[i];
  return {std::sqrt(a2 + u * (b2 - a2)), 0.5 * (b2 - a2) / way};
}

double SpeedPlan::duration_s() const {
  double sum = 0.0;
  for (std::size_t i = 1; i < speed_.size(); ++i) {
    sum += 2.0 * way_m(line_->points[i - 1], line_->points[i]) / std::max(speed_[i] + speed_[i - 1], 0.1);
  }
  return sum;
}

}  // namespace orthodrive
