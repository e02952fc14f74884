#pragma once
// The stage "drive": one lap in a simulated car whose four tyres ask the road surface 1000 times a second.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/drive/route.hpp"
#include "orthodrive/drive/vehicle.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive {

struct DriveOptions {
  RouteOptions route;
  Vehicle vehicle;
  Driver driver;
};

/// The car at one time. The reference point is the middle of the wheelbase and track on the road; angles follow from
/// the heights of the four contact points.
struct DriveSample {
  double t_s = 0.0;
  double s_m = 0.0;                        ///< along the driven line
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;  ///< site CRS
  double heading_rad = 0.0;                ///< from east, counter-clockwise, in (-pi, pi]
  double pitch_rad = 0.0;                  ///< positive: nose up
  double roll_rad = 0.0;                   ///< positive: left side up, like the superelevation
  double speed_mps = 0.0;
  double a_lon_mps2 = 0.0, a_lat_mps2 = 0.0;  ///< in the plane of the road, ahead and to the left
  double curvature_1pm = 0.0;                 ///< of the driven line
  double gradient = 0.0;                      ///< of the road in driving direction
  int road_id = -1;                           ///< OpenDRIVE id under the reference point; -1: none
  double road_s_m = 0.0, road_t_m = 0.0;
  std::array<double, 4> wheel_z_m{};  ///< front left, front right, rear left, rear right
};

struct DriveResult {
  Route route;
  std::vector<DriveSample> samples;  ///< every 10 ms, first at t = 0
  bool finished = false;             ///< came to the end of the line
  double lap_time_s = 0.0, length_m = 0.0;
  double max_speed_mps = 0.0, mean_speed_mps = 0.0;
  double max_lateral_mps2 = 0.0, max_braking_mps2 = 0.0, max_driving_mps2 = 0.0;
  double max_gradient = 0.0, min_gradient = 0.0, max_roll_rad = 0.0;
  double climb_m = 0.0;           ///< sum of all rises
  double max_line_error_m = 0.0;  ///< of the car from its line
  std::uint64_t tyre_queries = 0;
  std::uint64_t tyre_misses = 0;  ///< tyres with no road below
  double off_road_share = 0.0;    ///< misses / queries
  /// Largest step of a contact height between two milliseconds, beyond what the slope of the surface accounts for.
  double max_height_step_m = 0.0;
  double max_height_step_s_m = 0.0;  ///< where, along the driven line
  double wall_s = 0.0;               ///< of the simulation loop: differs from run to run
  Findings findings;

  [[nodiscard]] double tyre_queries_per_s() const {
    return wall_s > 0.0 ? static_cast<double>(tyre_queries) / wall_s : 0.0;
  }
  [[nodiscard]] double real_time_factor() const { return wall_s > 0.0 ? lap_time_s / wall_s : 0.0; }
};

/// Plans a route and a speed for every place of it (curvature, banking, gradient, power, brakes), then drives it:
/// single-track model with tyre slip, a steering controller after Stanley, semi-implicit Euler steps of 1 ms.
/// docs/roadquery.md, section "The lap". Single threaded.
[[nodiscard]] DriveResult simulate_lap(const roadquery::RoadMap& map, const DriveOptions& options = {},
                                       Monitor* monitor = nullptr);

}  // namespace orthodrive
