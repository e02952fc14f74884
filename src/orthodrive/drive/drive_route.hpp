// SPDX-License-Identifier: Apache-2.0
#pragma once
// The stage "drive": laps in a simulated car whose four tyres ask the road surface 1000 times a second.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/drive/car/driver.hpp"
#include "orthodrive/drive/car/envelope_table.hpp"
#include "orthodrive/drive/line/driving_line.hpp"
#include "orthodrive/drive/routes/route.hpp"
#include "roadquery/map/road_map.hpp"
#include "vehicle/car.hpp"

namespace orthodrive {

struct DriveOptions {
  RouteOptions route;
  vehicle::CarParameters car;  ///< from a file of models/vehicles
  Driver driver;
  DrivingStyle style = DrivingStyle::road;
  bool standing_start = false;  ///< a closed route begins at rest; else a lap to warm up comes first
  int laps = 1;                 ///< of a closed route, after the one to warm up
  bool stops = false;           ///< stand where other traffic goes first
  double step_s = 1e-3;         ///< of the car
  bool keep_samples = true;     ///< else the result has no samples
};

/// The car at one time. The reference point is the car's origin: the middle of wheelbase and track, at road level.
/// Wheels: front left, front right, rear left, rear right.
struct DriveSample {
  double t_s = 0.0;
  double s_m = 0.0;                        ///< along the driven line, lap after lap
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;  ///< site CRS
  double heading_rad = 0.0;                ///< from east, counter-clockwise, in (-pi, pi]
  double pitch_rad = 0.0;                  ///< of the body, positive: nose up
  double roll_rad = 0.0;                   ///< of the body, positive: left side up, like the superelevation
  double speed_mps = 0.0, planned_mps = 0.0;
  /// Of the centre of gravity, ahead, to the left and up along the car's axes; lateral without gravity's share.
  double a_lon_mps2 = 0.0, a_lat_mps2 = 0.0, a_vert_mps2 = 0.0;
  double yaw_rate_radps = 0.0, side_slip_rad = 0.0;
  double curvature_1pm = 0.0;  ///< of the driven line
  double gradient = 0.0;       ///< of the road in driving direction
  double banking_rad = 0.0;    ///< of the road, positive = left side higher
  double line_error_m = 0.0;   ///< of the reference point, positive = left of the line
  int road_id = -1;            ///< OpenDRIVE id under the reference point; -1: none
  double road_s_m = 0.0, road_t_m = 0.0;
  double steering_rad = 0.0;               ///< mean of the front wheels, positive = left
  double throttle = 0.0, brake = 0.0;      ///< pedals, 0 .. 1
  int gear = 0;                            ///< 0: neutral
  double engine_rpm = 0.0, fuel_kg = 0.0;  ///< fuel: burnt since the start
  std::array<double, 4> wheel_z_m{};       ///< of the road under the wheel
  std::array<double, 4> load_n{};
  std::array<double, 4> slip_ratio{};      ///< positive when driving
  std::array<double, 4> slip_angle_rad{};  ///< ISO 8855: positive = the wheel moves to its left
  std::array<double, 4> fx_n{}, fy_n{};    ///< on the tyre, along the wheel and to its left
};

struct DriveResult {
  Route route;
  vehicle::CarParameters car;
  DrivingLine line;
  std::vector<DriveSample> samples;  ///< every 10 ms, first at t = 0
  bool finished = false;             ///< came to the end of the route
  int finished_before_step = -1;     ///< the step with a bend too tight for the car, before which it stopped; -1: none
  double lap_time_s = 0.0;           ///< of the fastest lap, or of the whole way of an open route
  std::vector<double> lap_times_s;   ///< of every timed lap
  double length_m = 0.0;             ///< of what was timed
  double plan_time_s = 0.0;          ///< of a lap as planned
  double max_speed_mps = 0.0, mean_speed_mps = 0.0;
  double max_lateral_mps2 = 0.0, max_braking_mps2 = 0.0, max_driving_mps2 = 0.0;
  double max_vertical_mps2 = 0.0;  ///< either sign
  double max_gradient = 0.0, min_gradient = 0.0, max_roll_rad = 0.0;
  double climb_m = 0.0;  ///< sum of all rises
  double fuel_kg = 0.0;
  int stops = 0;
  double max_line_error_m = 0.0;  ///< of the car from its line
  std::uint64_t tyre_queries = 0;
  std::uint64_t tyre_misses = 0;  ///< tyres with no road below
  double off_road_share = 0.0;    ///< misses / queries
  /// Largest step of a contact height between two milliseconds, beyond what the slope of the surface accounts for.
  double max_height_step_m = 0.0;
  double max_height_step_s_m = 0.0;  ///< where, along the driven line
  double wall_s = 0.0;               ///< of the simulation loop: differs from run to run
  double driven_s = 0.0;             ///< simulated in that time, with the lap to warm up
  Findings findings;

  [[nodiscard]] double tyre_queries_per_s() const { return wall_s > 0.0 ? 4.0 * driven_s / step_s / wall_s : 0.0; }
  [[nodiscard]] double real_time_factor() const { return wall_s > 0.0 ? driven_s / wall_s : 0.0; }
  double step_s = 1e-3;  ///< as asked
};

/// Drives a route: plans a line and a speed for every place of it (curvature, banking, crests, gradient, the car's
/// envelope, speed limits), then drives it in the car of src/vehicle with a driver who steers and works the pedals 200
/// times a second. docs/drive.md. Single threaded, the same bytes every time but wall_s. A route below least_route_m
/// (lane_path.hpp) is not driven: the result has a finding and no line.
/// `envelope`: that of options.car.
[[nodiscard]] DriveResult drive_route(const roadquery::RoadQuery& query, const Route& route,
                                      const DriveOptions& options, const EnvelopeTable& envelope,
                                      Monitor* monitor = nullptr);

/// The roads without heights, banking and shape: what the third dimension changes can be told by driving both.
[[nodiscard]] roadquery::RoadMap flattened(roadquery::RoadMap map);

}  // namespace orthodrive
