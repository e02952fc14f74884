// SPDX-License-Identifier: Apache-2.0
#pragma once
// Stage "elevate": all of it in its order. Refined roads get heights, then banking, then the measurements of drive
// logs.

#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/elevate/banking/estimate_banking.hpp"
#include "orthodrive/elevate/logs/fuse_drive_logs.hpp"
#include "orthodrive/elevate/profiles/estimate_profiles.hpp"
#include "orthodrive/model/roads/drive_log.hpp"

namespace orthodrive {

struct ElevateRoadsOptions {
  ElevateOptions heights;
  BankingOptions banking;
  FuseDriveLogsOptions logs;  ///< its clearance is that of `heights`
};

struct ElevateRoadsResult {
  RoadNetwork roads;                        ///< every field of heights and banking set
  std::vector<RoughnessStretch> roughness;  ///< where logs were driven
  ProfileEnergy before, after;              ///< of `estimate_profiles`
  SolveSummary solve;                       ///< likewise
  double banking_measured_share = 0.0;      ///< of the nodes
  double logged_m = 0.0, logged_on_roads_m = 0.0;
  Findings findings;  ///< of all three, in this order
};

/// `log` may be empty. Throws OptionError as the three functions do.
[[nodiscard]] ElevateRoadsResult elevate_roads(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms,
                                               const DriveLog& log, const ElevateRoadsOptions& options = {},
                                               Monitor* monitor = nullptr);

}  // namespace orthodrive
