#include "orthodrive/drive/simulate_lap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "orthodrive/drive/driving_line.hpp"
#include "orthodrive/drive/speed_profile.hpp"
#include "roadquery/road_query.hpp"

namespace orthodrive {
namespace {

constexpr double step_s = 1e-3;
constexpr int steps_per_sample = 10;
constexpr double lost_m = 5.0;   // so far from its line the car does not find back
constexpr double bump_m = 0.02;  // a step as high as a lowered kerb is worth a finding
constexpr double finding_spacing_m = 10.0;
constexpr double speed_gain_1ps = 2.0;       // of the speed controller
constexpr double stanley_gain_1ps = 2.5;     // Hoffmann, Tomlin, Montemerlo, Thrun 2007, used 2.5 as well
constexpr double stanley_speed_mps = 1.0;    // keeps the correction finite at rest, ibid.
constexpr double kinematic_below_mps = 3.0;  // slip angles lose their meaning towards rest

/// State of the single-track model. Position of the centre of gravity; velocities in the car's frame.
struct Car {
  double x_m = 0.0, y_m = 0.0, heading_rad = 0.0;
  double ahead_mps = 0.0, left_mps = 0.0, yaw_radps = 0.0;
  double steer_rad = 0.0;
  double a_lon_mps2 = 0.0, a_lat_mps2 = 0.0;

  [[nodiscard]] Vec2 at(double ahead_m, double left_m) const {
    const double c = std::cos(heading_rad), s = std::sin(heading_rad);
    return {x_m + c * ahead_m - s * left_m, y_m + s * ahead_m + c * left_m};
  }
};

/// How the road tilts the car.
struct Attitude {
  double z_m = 0.0, pitch_rad = 0.0, roll_rad = 0.0;
};

/// The four contact points, each with its own cursor.
class Tyres {
 public:
  Tyres(const roadquery::RoadQuery& query, const Vehicle& vehicle, double z_m) : query_(query), vehicle_(vehicle) {
    z_m_.fill(z_m);
  }

  void update(const Car& car) {
    const double half_track_m = 0.5 * vehicle_.track_m;
    const std::array<std::pair<double, double>, 4> places = {{{vehicle_.front_axle_m, half_track_m},
                                                              {vehicle_.front_axle_m, -half_track_m},
                                                              {-vehicle_.rear_axle_m(), half_track_m},
                                                              {-vehicle_.rear_axle_m(), -half_track_m}}};
    step_m_ = 0.0;
    missed_ = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 p = car.at(places[i].first, places[i].second);
      const auto hit = query_.find(p.x, p.y, z_m_[i], cursors_[i]);
      if (hit) {
        if (last_[i]) {
          // What the tangent plane at the last contact point promised.
          const auto& n = last_[i]->normal;
          const double expected = last_[i]->z - (n[0] * (p.x - place_[i].x) + n[1] * (p.y - place_[i].y)) / n[2];
          step_m_ = std::max(step_m_, std::abs(hit->z - expected));
        }
        z_m_[i] = hit->z;
      } else {
        ++missed_;  // the tyre keeps its height
      }
      last_[i] = hit;
      place_[i] = p;
    }
  }

  [[nodiscard]] Attitude attitude() const {
    const auto& z = z_m_;
    return {0.25 * (z[0] + z[1] + z[2] + z[3]), std::atan(0.5 * (z[0] + z[1] - z[2] - z[3]) / vehicle_.wheelbase_m),
            std::atan(0.5 * (z[0] - z[1] + z[2] - z[3]) / vehicle_.track_m)};
  }
  [[nodiscard]] const std::array<double, 4>& z_m() const { return z_m_; }
  [[nodiscard]] double step_m() const { return step_m_; }  ///< largest step of a height at the last update
  [[nodiscard]] int missed() const { return missed_; }

 private:
  const roadquery::RoadQuery& query_;
  const Vehicle& vehicle_;
  std::array<roadquery::Cursor, 4> cursors_;
  std::array<std::optional<roadquery::Hit>, 4> last_;
  std::array<Vec2, 4> place_{};
  std::array<double, 4> z_m_{};
  double step_m_ = 0.0;
  int missed_ = 0;
};

/// Where the front axle is along its line; moves on from step to step.
struct Progress {
  double s_m = 0.0, error_m = 0.0;  ///< error: positive = left of the line

  void update(const DrivingLine& line, Vec2 front) {
    for (int i = 0; i < 3; ++i) {  // the line is nearly straight over one step: Newton converges at once
      const LinePoint p = line.at(s_m);
      const double c = std::cos(p.heading_rad), s = std::sin(p.heading_rad);
      const double dx = front.x - p.x_m, dy = front.y - p.y_m;
      error_m = dy * c - dx * s;
      s_m += (dx * c + dy * s) / std::max(1.0 - p.curvature_1pm * error_m, 0.2);
    }
  }
};

double lateral_gravity_mps2(double roll_rad) { return gravity_mps2 * std::sin(roll_rad); }

/// Front wheels along the line a steering lag ahead, plus the slip angle that the curve needs, plus Stanley's
/// correction.
double steering_rad(const DrivingLine& line, const Progress& progress, const Car& car, const Attitude& attitude,
                    const Vehicle& v) {
  const LinePoint ahead = line.at(progress.s_m + car.ahead_mps * v.steer_lag_s);
  const double heading_error =
      std::remainder(ahead.heading_rad - car.heading_rad - car.yaw_radps * v.steer_lag_s, 2.0 * std::numbers::pi);
  const double lateral_mps2 =
      car.ahead_mps * car.ahead_mps * ahead.curvature_1pm + lateral_gravity_mps2(attitude.roll_rad);
  const double slip = v.mass_kg * v.rear_axle_m() / v.wheelbase_m * lateral_mps2 / v.cornering_stiffness_front_n;
  const double correction = std::atan(-stanley_gain_1ps * progress.error_m / (stanley_speed_mps + car.ahead_mps));
  return std::clamp(heading_error + slip + correction, -v.max_steer_rad, v.max_steer_rad);
}

/// Force of the engine (> 0) or brakes (< 0) for the wanted acceleration, with what slows the car down made up for:
/// air, rolling, gradient and the backward part of the steered wheels' side force.
double traction_n(double wanted_mps2, const Car& car, const Attitude& attitude, const Vehicle& v) {
  const double cornering_mps2 = v.rear_axle_m() / v.wheelbase_m * car.a_lat_mps2 * std::sin(car.steer_rad);
  const double force = v.mass_kg * (wanted_mps2 + resistance_mps2(v, car.ahead_mps) + cornering_mps2 +
                                    gravity_mps2 * std::sin(attitude.pitch_rad));
  return std::clamp(force, -v.grip * v.mass_kg * gravity_mps2, v.mass_kg * engine_mps2(v, car.ahead_mps));
}

/// One semi-implicit Euler step: velocities first, then positions with the new velocities.
void move(Car& car, double traction, double wanted_steer_rad, const Attitude& attitude, const Vehicle& v) {
  const double steer_rate =
      std::clamp((wanted_steer_rad - car.steer_rad) / v.steer_lag_s, -v.steer_rate_radps, v.steer_rate_radps);
  car.steer_rad += step_s * steer_rate;

  const double resistance = car.ahead_mps > 0.0 ? resistance_mps2(v, car.ahead_mps) : 0.0;
  car.a_lon_mps2 = traction / v.mass_kg - resistance - gravity_mps2 * std::sin(attitude.pitch_rad);
  if (car.ahead_mps < kinematic_below_mps) {
    car.ahead_mps = std::max(car.ahead_mps + step_s * car.a_lon_mps2, 0.0);
    car.yaw_radps = car.ahead_mps * std::tan(car.steer_rad) / v.wheelbase_m;
    car.left_mps = car.yaw_radps * v.rear_axle_m();
    car.a_lat_mps2 = car.ahead_mps * car.yaw_radps;
  } else {
    const double weight_n = v.mass_kg * gravity_mps2 * std::cos(attitude.roll_rad) * std::cos(attitude.pitch_rad);
    const auto side_force_n = [&](double stiffness, double slip_rad, double share) {
      const double limit = v.grip * weight_n * share;
      return -limit * std::tanh(stiffness * slip_rad / limit);
    };
    const double slip_front = std::atan2(car.left_mps + v.front_axle_m * car.yaw_radps, car.ahead_mps) - car.steer_rad;
    const double slip_rear = std::atan2(car.left_mps - v.rear_axle_m() * car.yaw_radps, car.ahead_mps);
    const double front_n = side_force_n(v.cornering_stiffness_front_n, slip_front, v.rear_axle_m() / v.wheelbase_m);
    const double rear_n = side_force_n(v.cornering_stiffness_rear_n, slip_rear, v.front_axle_m / v.wheelbase_m);
    car.a_lon_mps2 -= front_n * std::sin(car.steer_rad) / v.mass_kg;
    car.a_lat_mps2 = (front_n * std::cos(car.steer_rad) + rear_n) / v.mass_kg - lateral_gravity_mps2(attitude.roll_rad);
    const double yaw_radps2 =
        (v.front_axle_m * front_n * std::cos(car.steer_rad) - v.rear_axle_m() * rear_n) / v.yaw_inertia_kgm2;
    car.ahead_mps += step_s * (car.a_lon_mps2 + car.left_mps * car.yaw_radps);
    car.left_mps += step_s * (car.a_lat_mps2 - car.ahead_mps * car.yaw_radps);
    car.yaw_radps += step_s * yaw_radps2;
  }
  car.heading_rad += step_s * car.yaw_radps;
  const double c = std::cos(car.heading_rad), s = std::sin(car.heading_rad);
  car.x_m += step_s * (c * car.ahead_mps - s * car.left_mps);
  car.y_m += step_s * (s * car.ahead_mps + c * car.left_mps);
}

/// Planned speed and acceleration at a place.
class Plan {
 public:
  Plan(const DrivingLine& line, std::vector<double> speed) : line_(line), speed_(std::move(speed)) {}
  struct At {
    double speed_mps = 0.0, acceleration_mps2 = 0.0;
  };
  [[nodiscard]] At at(double s_m) const {
    const auto& p = line_.points;
    if (line_.closed) s_m -= std::floor(s_m / line_.length_m()) * line_.length_m();
    const auto after =
        std::upper_bound(p.begin() + 1, p.end() - 1, s_m, [](double s, const LinePoint& q) { return s < q.s_m; });
    const auto i = static_cast<std::size_t>(after - p.begin());
    const double way_m = p[i].s_m - p[i - 1].s_m, u = std::clamp((s_m - p[i - 1].s_m) / way_m, 0.0, 1.0);
    // v^2 is linear in s where the acceleration is constant.
    const double a2 = speed_[i - 1] * speed_[i - 1], b2 = speed_[i] * speed_[i];
    return {std::sqrt(a2 + u * (b2 - a2)), 0.5 * (b2 - a2) / way_m};
  }
  [[nodiscard]] double duration_s() const {
    double sum = 0.0;
    for (std::size_t i = 1; i < speed_.size(); ++i) {
      sum += 2.0 * (line_.points[i].s_m - line_.points[i - 1].s_m) / (speed_[i] + speed_[i - 1]);
    }
    return sum;
  }

 private:
  const DrivingLine& line_;
  std::vector<double> speed_;
};

/// On the line at s (of the front axle) with that speed. On a closed line it has been driving before.
Car place_car(const DrivingLine& line, double s_m, double speed_mps, const Vehicle& v) {
  const LinePoint front = line.at(s_m), rear = line.at(s_m - v.wheelbase_m);
  Car car;
  car.heading_rad = std::atan2(front.y_m - rear.y_m, front.x_m - rear.x_m);
  car.x_m = front.x_m - v.front_axle_m * std::cos(car.heading_rad);
  car.y_m = front.y_m - v.front_axle_m * std::sin(car.heading_rad);
  car.ahead_mps = speed_mps;
  car.yaw_radps = speed_mps * front.curvature_1pm;
  car.left_mps = car.yaw_radps * v.rear_axle_m();
  car.steer_rad = std::atan(v.wheelbase_m * front.curvature_1pm);
  return car;
}

/// Findings of one kind, one a place: what follows within a few metres belongs to the one before.
class SpacedFindings {
 public:
  explicit SpacedFindings(Findings& findings) : findings_(findings) {}
  void add(double s_m, Finding finding) {
    const bool near = s_m < last_s_m_ + finding_spacing_m;
    last_s_m_ = s_m;
    if (!near) findings_.push_back(std::move(finding));
  }

 private:
  Findings& findings_;
  double last_s_m_ = -1e300;
};

/// Everything that moves, and what it moves on.
struct Lap {
  const roadquery::RoadQuery& query;
  const DrivingLine& line;
  const Plan& plan;
  const Vehicle& vehicle;
  const Driver& driver;
  Car car;
  Tyres tyres;
  Progress progress;
  roadquery::Cursor cursor;  ///< of the middle of the car

  Lap(const roadquery::RoadQuery& query, const DrivingLine& line, const Plan& plan, const DriveOptions& options,
      double start_m)
      : query(query),
        line(line),
        plan(plan),
        vehicle(options.vehicle),
        driver(options.driver),
        car(place_car(line, start_m, line.closed ? plan.at(start_m).speed_mps : 0.0, vehicle)),
        tyres(query, vehicle, line.at(start_m).z_m),
        progress{start_m} {
    tyres.update(car);
  }

  void advance() {
    const Attitude attitude = tyres.attitude();
    const Plan::At planned = plan.at(progress.s_m);
    const double wanted_mps2 = std::min(
        planned.acceleration_mps2 + speed_gain_1ps * (planned.speed_mps - car.ahead_mps), driver.max_drive_mps2);
    move(car, traction_n(wanted_mps2, car, attitude, vehicle), steering_rad(line, progress, car, attitude, vehicle),
         attitude, vehicle);
    tyres.update(car);
    progress.update(line, car.at(vehicle.front_axle_m, 0.0));
  }

  [[nodiscard]] DriveSample sample(double t_s) {
    const Vec2 middle = car.at(0.5 * vehicle.wheelbase_m - vehicle.rear_axle_m(), 0.0);
    const Attitude attitude = tyres.attitude();
    DriveSample sample;
    sample.t_s = t_s, sample.s_m = progress.s_m;
    sample.x_m = middle.x, sample.y_m = middle.y, sample.z_m = attitude.z_m;
    sample.heading_rad = std::remainder(car.heading_rad, 2.0 * std::numbers::pi);
    sample.pitch_rad = attitude.pitch_rad, sample.roll_rad = attitude.roll_rad;
    sample.speed_mps = std::hypot(car.ahead_mps, car.left_mps);
    sample.a_lon_mps2 = car.a_lon_mps2, sample.a_lat_mps2 = car.a_lat_mps2;
    sample.curvature_1pm = line.at(progress.s_m).curvature_1pm;
    sample.gradient = std::tan(attitude.pitch_rad);
    if (const auto hit = query.find(middle.x, middle.y, attitude.z_m, cursor)) {
      sample.road_id = query.map().roads[static_cast<std::size_t>(hit->road)].id;
      sample.road_s_m = hit->s, sample.road_t_m = hit->t;
    }
    sample.wheel_z_m = tyres.z_m();
    return sample;
  }
};

void summarize(DriveResult& result) {
  for (std::size_t i = 0; i < result.samples.size(); ++i) {
    const DriveSample& s = result.samples[i];
    result.max_speed_mps = std::max(result.max_speed_mps, s.speed_mps);
    result.max_lateral_mps2 = std::max(result.max_lateral_mps2, std::abs(s.a_lat_mps2));
    result.max_braking_mps2 = std::max(result.max_braking_mps2, -s.a_lon_mps2);
    result.max_driving_mps2 = std::max(result.max_driving_mps2, s.a_lon_mps2);
    result.max_gradient = std::max(result.max_gradient, s.gradient);
    result.min_gradient = std::min(result.min_gradient, s.gradient);
    result.max_roll_rad = std::max(result.max_roll_rad, std::abs(s.roll_rad));
    if (i > 0) result.climb_m += std::max(s.z_m - result.samples[i - 1].z_m, 0.0);
  }
  if (result.lap_time_s > 0.0) result.mean_speed_mps = result.length_m / result.lap_time_s;
  if (result.tyre_queries > 0) {
    result.off_road_share = static_cast<double>(result.tyre_misses) / static_cast<double>(result.tyre_queries);
  }
}

}  // namespace

DriveResult simulate_lap(const roadquery::RoadMap& map, const DriveOptions& options, Monitor* monitor) {
  const Vehicle& vehicle = options.vehicle;
  DriveResult result;
  result.route = find_route(map, options.route);
  const roadquery::RoadQuery query(map);
  const DrivingLine line = make_driving_line(query, result.route);
  const Plan plan(line, plan_speed(line, vehicle, options.driver));
  if (!result.route.closed) {
    const LinePoint& end = line.points.back();
    result.findings.push_back(
        {Severity::warning, "drive.open_route",
         fmt::format("no closed loop along '{}': drove {:.0f} m to its end here", result.route.name, line.length_m()),
         end.x_m, end.y_m});
  }

  // The front axle starts at the line's start; on an open one far enough into it for the rear axle to stand on the
  // road.
  const double start_m = line.closed ? 0.0 : std::min(vehicle.wheelbase_m + 0.5, 0.5 * line.length_m());
  Lap lap(query, line, plan, options, start_m);
  result.samples.push_back(lap.sample(0.0));

  SpacedFindings bumps(result.findings), misses(result.findings);
  const auto max_steps = static_cast<long>((4.0 * plan.duration_s() + 60.0) / step_s);
  const auto clock_start = std::chrono::steady_clock::now();
  long step = 0;
  while (lap.progress.s_m < line.length_m() && step < max_steps && std::abs(lap.progress.error_m) < lost_m) {
    if (monitor != nullptr && step % 1000 == 0) {
      if (monitor->cancelled()) break;
      monitor->progress(lap.progress.s_m / line.length_m(), "drive");
    }
    lap.advance();
    ++step;

    result.tyre_queries += 4;
    result.tyre_misses += static_cast<std::uint64_t>(lap.tyres.missed());
    result.max_line_error_m = std::max(result.max_line_error_m, std::abs(lap.progress.error_m));
    if (lap.tyres.missed() > 0) {
      misses.add(lap.progress.s_m, {Severity::warning, "drive.off_road",
                                    fmt::format("a tyre leaves the road {:.0f} m into the lap", lap.progress.s_m),
                                    lap.car.x_m, lap.car.y_m});
    }
    if (lap.tyres.step_m() > bump_m) {
      bumps.add(lap.progress.s_m,
                {Severity::warning, "drive.bump",
                 fmt::format("the road surface has a step of {:.3f} m", lap.tyres.step_m()), lap.car.x_m, lap.car.y_m});
    }
    if (lap.tyres.step_m() > result.max_height_step_m) {
      result.max_height_step_m = lap.tyres.step_m(), result.max_height_step_s_m = lap.progress.s_m;
    }
    if (step % steps_per_sample == 0) {
      result.samples.push_back(lap.sample(static_cast<double>(step) * step_s));
    }
  }
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - clock_start).count();
  result.finished = lap.progress.s_m >= line.length_m();
  if (!result.finished) {
    const char* why =
        std::abs(lap.progress.error_m) >= lost_m ? "the car lost its line" : "the car was stopped or far too slow";
    result.findings.push_back(
        {Severity::error, "drive.not_finished",
         fmt::format("{} {:.0f} m into the lap of {:.0f} m", why, lap.progress.s_m, line.length_m()), lap.car.x_m,
         lap.car.y_m});
  }
  result.lap_time_s = static_cast<double>(step) * step_s;
  result.length_m = lap.progress.s_m - start_m;
  summarize(result);
  if (monitor != nullptr) monitor->progress(1.0, "drive");
  return result;
}

}  // namespace orthodrive
