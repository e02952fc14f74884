// SPDX-License-Identifier: Apache-2.0
#pragma once
// Drives every road of a network once: what a car would stumble over is found before it does.

#include "orthodrive/drive/drive_route.hpp"

namespace orthodrive {

struct AllRoadsResult {
  int routes = 0, finished = 0;           ///< finished: driven to the end
  int too_short = 0;                      ///< routes shorter than the car needs: not driven
  double length_m = 0.0, routes_m = 0.0;  ///< driven; of all routes together
  double driven_s = 0.0, wall_s = 0.0;    ///< simulated; of the loop, which differs from run to run
  double max_vertical_mps2 = 0.0, max_height_step_m = 0.0, max_line_error_m = 0.0;
  std::uint64_t tyre_queries = 0, tyre_misses = 0;
  int off_road_places = 0, jolt_places = 0, bump_places = 0;
  int too_tight_places = 0;  ///< bends that the car cannot take in one go: it stopped before and began anew behind
  Findings findings;         ///< of all routes, those within 10 m of one of the same kind left out; sorted by route
};

/// Routes over every road of the largest connected part (route_cover.hpp), each driven from rest at the speed limits.
/// `options.route`, `laps`, `racing` do not count. The result does not depend on `threads` (0: all cores).
[[nodiscard]] AllRoadsResult drive_all_roads(const roadquery::RoadMap& map, const DriveOptions& options,
                                             int threads = 0, Monitor* monitor = nullptr);

}  // namespace orthodrive
