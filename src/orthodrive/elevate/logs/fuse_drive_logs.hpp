// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a drive log says of roads: gradient, banking and roughness, added with the weight that their accuracy deserves.
//
// The profile of the terrain is right in the mean but wrong from place to place; a drive measures gradients well and
// heights only up to an offset that drifts. Both enter one sparse least-squares problem over the roads that were driven
// on and those that meet them. Equations: docs/drive_logs.md. The steps are files of their own, in the order of the
// algorithm: match_log, driven_samples, road_meetings, fusion_problem, correction_prior, sensor_model,
// solve_corrections.

#include <cstddef>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/elevate/logs/match_log.hpp"
#include "orthodrive/elevate/logs/measure_roughness.hpp"
#include "orthodrive/model/roads/drive_log.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/road_roughness.hpp"
#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive {

/// Standard deviations of what a log holds, one pose or sample each. Errors within `correlation_s` are one error: more
/// poses a second are no more evidence.
struct DriveLogAccuracy {
  double pitch_rad = 0.005, pitch_correlation_s = 1.0;  ///< without mounting and suspension
  double roll_rad = 0.007, roll_correlation_s = 1.0;
  double climb_mps = 0.10, climb_correlation_s = 1.0;      ///< vertical velocity
  double lateral_mps2 = 0.3, lateral_correlation_s = 0.5;  ///< lateral specific force against speed times yaw rate
  double height_m = 0.05, height_correlation_s = 0.5;      ///< from pose to pose
  double height_drift_m = 2.0, height_drift_s = 120.0;     ///< Gauss-Markov process: standard deviation, time constant
  double mounting_rad = 0.1;                               ///< of the sensor in the car, pitch and roll each
};

/// Expected body movement per specific force and its spread over cars: Gillespie, Fundamentals of vehicle dynamics,
/// 1992, has roll of 3 to 7 deg/g; pitch when accelerating and braking is about a third of it.
struct SuspensionPrior {
  double pitch_rad_per_mps2 = 0.003, pitch_sigma = 0.0025;  ///< nose up under a forward specific force
  double roll_rad_per_mps2 = 0.0080, roll_sigma = 0.0035;   ///< left side up under a specific force to the left
};

struct FuseDriveLogsOptions {
  DriveLogAccuracy accuracy;
  SuspensionPrior suspension;
  MeasureRoughnessOptions roughness;
  double terrain_error_length_m = 30.0;  ///< errors of the given profile are alike over it (Matern 5/2 covariance)
  double banking_length_m = 60.0;        ///< the same of the given banking
  /// Of nodes without standard deviations: a street falls by 2.5 % (RASt 06) to either side.
  double unknown_sigma_z_m = 1.0, unknown_sigma_banking_rad = 0.025;
  double knot_spacing_m = 6.0;  ///< of the correction, a cubic spline
  double clearance_m = 4.7;     ///< of roads on two levels; less is reported
};

/// How a source's sensor sat in its car, and how the car's body moves.
struct DriveCalibration {
  std::string source;
  double mount_pitch_rad = 0.0, sigma_mount_pitch_rad = 0.0;  ///< nose up positive
  double mount_roll_rad = 0.0, sigma_mount_roll_rad = 0.0;    ///< left side up positive; it includes the crown
  double pitch_rad_per_mps2 = 0.0, sigma_pitch_rad_per_mps2 = 0.0;
  double roll_rad_per_mps2 = 0.0, sigma_roll_rad_per_mps2 = 0.0;
};

/// A node that was driven over, and the standard deviation of its gradient, which RoadNode does not hold.
struct DrivenNode {
  std::size_t path = 0, node = 0;
  double sigma_gradient = 0.0;
};

/// Root mean squares of measurement minus result; 0 where nothing was measured.
struct DriveResiduals {
  double pitch_rad = 0.0, climb_gradient = 0.0, roll_rad = 0.0, lateral_rad = 0.0, height_m = 0.0;
  std::size_t places = 0;  ///< driven samples: 2 m of road each, or one pose
};

struct FuseDriveLogsResult {
  RoadNetwork roads;  ///< z_m, gradient, banking and both sigmas updated; banking_source "log" where driven
  std::vector<DrivenNode> driven;           ///< ordered by path and node
  std::vector<RoughnessStretch> roughness;  ///< ordered by path and s
  std::vector<DriveCalibration> calibration;
  DriveResiduals residuals;
  double length_m = 0.0, matched_m = 0.0;
  SolveSummary solve;
  Findings findings;  ///< of matching; "elevate.log_disagrees", "elevate.log_clearance", "elevate.log_not_converged"
};

/// Needs the heights of `estimate_profiles` and roads in the CRS of the log; throws OptionError otherwise. Corrections
/// are C2 along every road and agree in height where roads meet, so that a result is as smooth as what it came from; a
/// side road keeps its angle to the driven one's surface. The crown is taken as known: a car on one side of the ridge
/// leans by banking and crown.
[[nodiscard]] FuseDriveLogsResult fuse_drive_logs(const RoadNetwork& roads, const DriveLog& log,
                                                  const FuseDriveLogsOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
