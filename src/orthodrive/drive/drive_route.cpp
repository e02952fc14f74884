// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/drive_route.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "orthodrive/drive/car/driver_model.hpp"
#include "orthodrive/drive/car/heave.hpp"
#include "orthodrive/drive/car/monitored_road.hpp"
#include "orthodrive/drive/car/speed_profile.hpp"
#include "orthodrive/drive/car/steering_limits.hpp"
#include "orthodrive/drive/lap_recorder.hpp"
#include "orthodrive/drive/line/lane_path.hpp"
#include "orthodrive/drive/line/line_ends.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

constexpr double control_s = 5e-3;
constexpr int controls_per_sample = 2;
constexpr double lost_m = 5.0;  // so far from its line, or back on it, the car does not find back
constexpr double progress_m = 1.0, progress_within_s = 60.0;  // less is standing: as on ice, or before a wall
constexpr double tyre_width_m = 0.25;                         // of both halves that stand beyond the tracks
constexpr double racing_margin_m = 0.5, road_margin_m = 0.2;
constexpr double reach_before_line_m = 1e-9;
constexpr double before_bend_m = 6.0,
                 least_way_m = 12.0;  // ends so far before a bend that is too tight; drives no less
constexpr int bump_rounds = 4;
constexpr std::size_t bump_run_up = 5;  // points, about metres
constexpr double slowest_over_bumps_mps = 1.5;
constexpr double full_lock_share = 0.9;  // the rest is left to correct with

/// From where to where a run is timed, along its line (lap after lap).
struct Timing {
  double from_m = 0.0, to_m = 0.0;
  double origin_m = 0.0;  ///< places are told from here
  double lap_m = 0.0;     ///< a time is noted every so many metres
  double most_s = 0.0;    ///< then the run is given up
};

/// Everything that moves, and what it moves on.
class Run {
 public:
  Run(const roadquery::RoadQuery& query, const DriveOptions& options, const EnvelopeTable& envelope,
      const SpeedPlan& plan, DriveResult& result, std::vector<double> stops_m)
      : options_(options),
        result_(result),
        car_(options.car),
        road_(query),
        driver_(options.car, envelope, options.driver, result.line, plan, std::move(stops_m)),
        recorder_(query, plan, result) {}

  void place(double s_m, double speed_mps) {
    const double half_m = 0.5 * options_.car.body.wheelbase_m;
    const LinePoint middle = result_.line.at(s_m), front = result_.line.at(s_m + half_m),
                    rear = result_.line.at(s_m - half_m);
    car_.place(middle.x_m, middle.y_m, std::atan2(front.y_m - rear.y_m, front.x_m - rear.x_m), speed_mps, road_,
               middle.z_m);
    driver_.begin(s_m);
    (void)road_.take();
  }

  /// False when the car does not come to the end: why_not() says why.
  bool drive(const Timing& timing, Monitor* monitor) {
    const long steps = std::max(1L, std::lround(control_s / options_.step_s));
    const double last_line_m = timing.to_m + 0.5 * timing.lap_m;
    double next_line_m = timing.from_m, last_crossing_s = 0.0;
    for (long tick = 0; static_cast<double>(tick) * control_s < timing.most_s; ++tick) {
      if (monitor != nullptr && tick % 400 == 0) {
        if (monitor->cancelled()) return false;
        monitor->progress(std::clamp(driver_.s_m() / timing.to_m, 0.0, 1.0), "drive");
      }
      const vehicle::Controls controls = driver_.drive(car_.state(), control_s);
      const double s_m = driver_.s_m(), now_s = static_cast<double>(tick) * control_s;
      while (next_line_m < last_line_m && s_m >= next_line_m - reach_before_line_m) {
        const double since_s = (s_m - next_line_m) / std::max(car_.state().speed_mps, 0.1);
        const double crossing_s = now_s - std::min(since_s, 2.0 * control_s);
        if (next_line_m > timing.from_m) result_.lap_times_s.push_back(crossing_s - last_crossing_s);
        last_crossing_s = crossing_s;
        next_line_m += timing.lap_m;
      }
      const bool timed = next_line_m > timing.from_m;
      if (s_m >= timing.to_m - reach_before_line_m) return true;
      if (!gets_on(s_m, now_s)) return false;
      if (timed && timed_ticks_++ % controls_per_sample == 0 && options_.keep_samples)
        recorder_.sample(static_cast<double>(timed_ticks_ - 1) * control_s, car_.state(), controls, driver_,
                         s_m - timing.origin_m);
      advance(steps, controls, timed, s_m - timing.origin_m);
    }
    return false;
  }

  [[nodiscard]] const DriverModel& driver() const { return driver_; }
  [[nodiscard]] const char* why_not() const { return why_not_; }
  [[nodiscard]] const vehicle::State& state() const { return car_.state(); }
  [[nodiscard]] double clock_s() const { return static_cast<double>(timed_ticks_) * control_s; }

 private:
  /// False for a car that has lost its line, rolls back, or stands.
  bool gets_on(double s_m, double now_s) {
    if (progress_s_ < 0.0 || s_m >= progress_m_ + progress_m) progress_m_ = s_m, progress_s_ = now_s;
    if (std::abs(driver_.error_m()) >= lost_m)
      why_not_ = "the car lost its line";
    else if (s_m <= progress_m_ - lost_m)
      why_not_ = "the car rolls back: the road climbs more than it can";
    else if (now_s < progress_s_ + progress_within_s)
      return true;
    return false;
  }

  void advance(long steps, const vehicle::Controls& controls, bool timed, double s_m) {
    for (long step = 0; step < steps; ++step) {
      car_.step(options_.step_s, controls, road_);
      const MonitoredRoad::Seen seen = road_.take();
      if (timed) recorder_.step(car_.state(), driver_, seen, s_m);
    }
    result_.driven_s += static_cast<double>(steps) * options_.step_s;
  }

  const DriveOptions& options_;
  DriveResult& result_;
  vehicle::Car car_;
  MonitoredRoad road_;
  DriverModel driver_;
  LapRecorder recorder_;
  long timed_ticks_ = 0;
  double progress_m_ = 0.0, progress_s_ = -1.0;  ///< the last place that it got on to, and when
  const char* why_not_ = "the car was stopped or far too slow";
};

LineOptions line_options(const DriveOptions& options) {
  return {.style = options.style,
          .car_width_m = std::max(options.car.front.track_m, options.car.rear.track_m) + tyre_width_m,
          .wheelbase_m = options.car.body.wheelbase_m,
          .margin_m = options.style == DrivingStyle::road ? road_margin_m : racing_margin_m,
          .most_curvature_1pm = full_lock_share * full_lock_curvature_1pm(options.car)};
}

/// Before what was found on the way.
void report_open_route(bool at_end, std::size_t before, DriveResult& result) {
  const LinePoint& end = result.line.points.back();
  Finding finding{Severity::warning, "drive.open_route",
                  fmt::format("no closed loop along '{}': {} {:.0f} m{}", result.route.name, at_end ? "drove" : "it is",
                              result.line.length_m(), at_end ? " to its end here" : " long and ends here"),
                  end.x_m, end.y_m};
  result.findings.insert(result.findings.begin() + static_cast<std::ptrdiff_t>(before), std::move(finding));
}

void report_unfinished(const Run& run, const Timing& timing, DriveResult& result) {
  result.findings.push_back({Severity::error, "drive.not_finished",
                             fmt::format("{}, {:.0f} m from the start, of {:.0f} m to drive", run.why_not(),
                                         std::max(run.driver().s_m(), 0.0), timing.to_m),
                             run.state().x_m, run.state().y_m});
}

/// False, with a finding, where the route is too short for a car: the result has no line then.
bool make_line(const roadquery::RoadQuery& query, const DriveOptions& options, DriveResult& result) {
  try {
    result.line = make_driving_line(query, result.route, line_options(options));
    return true;
  } catch (const TooShortError& error) {
    const RouteStep& first = result.route.steps.front();
    const roadquery::Road& road = query.map().roads[static_cast<std::size_t>(first.road)];
    const auto at = roadquery::reference_point(road, first.forward ? 0.0 : road.length);
    result.findings.push_back(
        {Severity::warning, "drive.too_short", fmt::format("{}: nothing is driven", error.what()), at.x, at.y});
    return false;
  }
}

/// Says where the road is banked more than the tyres hold at the planned speed.
void report_steep_bank(const EnvelopeTable& envelope, const Driver& driver, const std::vector<double>& speed_mps,
                       DriveResult& result) {
  const auto place = first_too_steep_bank(result.line, envelope, driver, speed_mps);
  if (!place) return;
  const LinePoint& p = result.line.points[place->point];
  const std::string when =
      place->least_mps ? fmt::format("below {:.0f} km/h", 3.6 * *place->least_mps) : "at any speed";
  result.findings.push_back(
      {Severity::warning, "drive.steep_bank",
       fmt::format("the road is banked by {:.0f} degrees: the car slides down it {}, and is to "
                   "drive {:.0f} km/h",
                   std::abs(p.banking) * 180.0 / std::numbers::pi, when, 3.6 * speed_mps[place->point]),
       p.x_m, p.y_m});
}

/// Ends the line before the first bend that the car cannot take. False: nothing is left of it to drive on.
bool stop_before_tight_bend(DriveResult& result) {
  const auto bend = first_too_tight(result.car, result.line);
  if (!bend) return true;
  result.finished_before_step = bend->step;
  result.findings.push_back(
      {Severity::warning, "drive.too_tight",
       fmt::format("the way bends tighter than the car can turn: to a radius of {:.1f} m, the car needs {:.1f} m",
                   1.0 / bend->curvature_1pm, 1.0 / full_lock_curvature_1pm(result.car)),
       bend->x_m, bend->y_m});
  auto& points = result.line.points;
  while (points.size() > 1 && points.back().s_m > bend->s_m - before_bend_m) points.pop_back();
  result.line.closed = result.route.closed = false;
  return result.line.length_m() >= least_way_m;
}

/// Stops of every lap of a closed line; those of an open one as they are.
std::vector<double> stops_of_laps(const std::vector<double>& stops_m, const DrivingLine& line, double to_m) {
  std::vector<double> all = stops_m;
  for (double from_m = line.length_m(); line.closed && from_m < to_m; from_m += line.length_m())
    for (const double stop_m : stops_m) all.push_back(from_m + stop_m);
  return all;
}

SpeedCaps caps_of(const roadquery::RoadQuery& query, const DriveOptions& options, const EnvelopeTable& envelope,
                  const DriveResult& result) {
  SpeedCaps caps;
  if (options.style == DrivingStyle::road) {
    caps.legal_mps = legal_speeds(query, result.route, result.line);
    slow_down_to_steer(options.car, envelope, result.line, options.driver.max_lateral_mps2, caps.legal_mps);
  }
  if (options.stops) caps.stops_m = give_way_places(query.map(), result.route, result.line);
  return caps;
}

/// Speeds for every point of the line, slower where the body would be thrown up and down: what comes shortly before a
/// bump throws it as well, so the places before count with it. Never slower than holds the car on a bank.
std::vector<double> plan_over_bumps(const roadquery::RoadQuery& query, const DriveOptions& options,
                                    const DrivingLine& line, const EnvelopeTable& envelope, SpeedCaps caps) {
  std::vector<double> speed = plan_speed(line, envelope, options.driver, caps);
  if (options.style != DrivingStyle::road) return speed;
  const AxleHeights heights = axle_heights(query, line, options.car);
  const std::vector<double> least_mps = least_speeds_on_banks(line, envelope, options.driver);
  for (int round = 0; round < bump_rounds; ++round) {
    const std::vector<double> heave = heave_mps2(line, heights, speed, options.car);
    std::vector<double> slower(speed.size(), 1.0);
    for (std::size_t i = 0; i < heave.size(); ++i) {
      const double share = options.driver.max_heave_mps2 / std::max(heave[i], 1e-6);
      for (std::size_t k = i - std::min(i, bump_run_up); k <= i && share < 1.0; ++k)
        slower[k] = std::min(slower[k], share);
    }
    if (std::all_of(slower.begin(), slower.end(), [](double share) { return share > 0.98; })) break;
    for (std::size_t i = 0; i < speed.size(); ++i)
      if (slower[i] < 1.0)
        caps.legal_mps[i] =
            std::max({slower[i] * speed[i], slowest_over_bumps_mps, std::min(least_mps[i], caps.legal_mps[i])});
    speed = plan_speed(line, envelope, options.driver, caps);
  }
  return speed;
}

/// Where a line is started and timed: an open one with room for the wheels; a closed one has a lap to warm up before.
Timing timing_of(const roadquery::RoadMap& map, const DriveOptions& options, const DriveResult& result, double stop_s) {
  const DrivingLine& line = result.line;
  const double length_m = line.length_m();
  Timing timing;
  if (line.closed) {
    timing.lap_m = length_m;
    timing.from_m = options.standing_start ? 0.0 : length_m;
    timing.origin_m = timing.from_m;
    timing.to_m = timing.from_m + static_cast<double>(std::max(options.laps, 1)) * length_m;
  } else {
    const LineEnds ends = room_for_wheels(map, result.route, line, line_options(options));
    timing.from_m = ends.from_m, timing.to_m = ends.to_m;
    timing.lap_m = timing.to_m - timing.from_m;
  }
  timing.most_s = (4.0 * result.plan_time_s + 60.0 + 2.0 * stop_s) * timing.to_m / length_m;
  return timing;
}

void summarize(DriveResult& result, const Run& run, const Timing& timing) {
  result.stops = run.driver().stops_made();
  result.length_m = std::clamp(run.driver().s_m(), timing.from_m, timing.to_m) - timing.from_m;
  const auto& laps = result.lap_times_s;
  result.lap_time_s = laps.empty() ? run.clock_s() : *std::min_element(laps.begin(), laps.end());
  double timed_s = 0.0;
  for (const double lap_s : laps) timed_s += lap_s;
  if (laps.empty()) timed_s = run.clock_s();
  if (timed_s > 0.0) result.mean_speed_mps = result.length_m / timed_s;
  if (result.tyre_queries > 0)
    result.off_road_share = static_cast<double>(result.tyre_misses) / static_cast<double>(result.tyre_queries);
}

}  // namespace

DriveResult drive_route(const roadquery::RoadQuery& query, const Route& route, const DriveOptions& options,
                        const EnvelopeTable& envelope, Monitor* monitor) {
  DriveResult result;
  result.route = route, result.car = options.car, result.step_s = options.step_s;
  if (!make_line(query, options, result)) return result;
  if (options.style != DrivingStyle::racing && !stop_before_tight_bend(result)) return result;
  const SpeedCaps caps = caps_of(query, options, envelope, result);
  const std::vector<double> speed_mps = plan_over_bumps(query, options, result.line, envelope, caps);
  report_steep_bank(envelope, options.driver, speed_mps, result);
  const SpeedPlan plan(result.line, speed_mps);
  result.plan_time_s = plan.duration_s();

  const Timing timing =
      timing_of(query.map(), options, result, static_cast<double>(caps.stops_m.size()) * (options.driver.stop_s + 5.0));
  Run run(query, options, envelope, plan, result, stops_of_laps(caps.stops_m, result.line, timing.to_m));
  const bool rolling = result.route.closed && !options.standing_start;
  const double start_m = result.route.closed ? 0.0 : timing.from_m;
  run.place(start_m, rolling ? plan.at(start_m).speed_mps : 0.0);
  const std::size_t found_before = result.findings.size();
  const auto clock_start = std::chrono::steady_clock::now();
  const bool at_end = run.drive(timing, monitor);
  result.finished = at_end && result.finished_before_step < 0;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - clock_start).count();
  if (!result.route.closed) report_open_route(at_end, found_before, result);
  if (!at_end) report_unfinished(run, timing, result);
  summarize(result, run, timing);
  if (monitor != nullptr) monitor->progress(1.0, "drive");
  return result;
}

roadquery::RoadMap flattened(roadquery::RoadMap map) {
  for (roadquery::Road& road : map.roads) {
    road.elevation.clear(), road.superelevation.clear(), road.shape.clear(), road.surface.clear();
  }
  for (roadquery::Junction& junction : map.junctions) junction.surface.reset();
  map.crgs.reset();
  return map;
}

}  // namespace orthodrive
