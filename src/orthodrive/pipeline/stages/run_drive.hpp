// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "drive": OpenDRIVE roads -> a drive, as tables, a page and in the formats of other programs.

#include <optional>

#include "orthodrive/drive/line/driving_line.hpp"
#include "orthodrive/drive/routes/route.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"

namespace orthodrive {

struct DriveFiles {
  std::filesystem::path network;
  std::filesystem::path folder;  ///< written: lap.csv, cycle.csv, lap.gpx, lap.xosc, report.html
  std::filesystem::path plots;   ///< written unless empty: the plots alone, to put into another page
};

struct RunDriveOptions {
  RouteOptions route;
  std::string vehicle = "auto";  ///< family, sports, gt3, a file, or auto: sports when racing, else family
  /// Nothing: centre on roads without lanes, racing where the larger part of the route are raceways, else road.
  std::optional<DrivingStyle> style;
  bool standing_start = false, stops = false;
  int laps = 1;
  double bare_width_m = 7.0;                              ///< of roads that are a reference line alone
  bool flat = false;                                      ///< without the heights of the roads
  bool all_roads = false;                                 ///< instead of a route: every road once (drive_all_roads.hpp)
  double step_ms = 1.0;                                   ///< of the car
  std::optional<double> max_speed_mps, max_lateral_mps2;  ///< other than the driver's own
};

/// Throws InputError for a network or vehicle file that cannot be read, OptionError for a route that does not exist.
StageOutcome run_drive(const DriveFiles& files, const RunDriveOptions& options, StageContext& context);

[[nodiscard]] BuildStage drive_stage(SiteBuild& build);

}  // namespace orthodrive
