// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 2 of fuse_drive_logs: what a matched recording measured, averaged over 2 m of road each.

#include <cstddef>
#include <optional>
#include <vector>

#include "orthodrive/elevate/logs/match_log.hpp"
#include "orthodrive/model/roads/drive_log.hpp"
#include "orthodrive/roads/log_chains.hpp"

namespace orthodrive::elevate {

/// Means over the poses of some metres of road; `not_recorded` where a log lacks a quantity.
struct DrivenSample {
  std::size_t chain = 0, recording = 0, source = 0;
  double along_m = 0.0;                             ///< on the chain
  double beside_m = 0.0;                            ///< to its left
  double direction = 1.0;                           ///< +1: driven along the chain
  double time_s = 0.0, span_s = 0.0, step_s = 0.0;  ///< span: the time that the sample covers; step: between its poses
  double z_m = not_recorded, nose_up_rad = not_recorded, roll_rad = not_recorded, speed_mps = not_recorded,
         climb_mps = not_recorded;
  double forward_mps2 = not_recorded, left_mps2 = not_recorded;  ///< specific force
  double acceleration_mps2 = not_recorded;                       ///< change of speed, for logs without accelerometer
  double yaw_rate_radps = not_recorded;
};

/// The samples of one recording in the order of driving. `places` has one entry per pose (match_log.hpp); poses on no
/// road are skipped. `number` is the recording's index in the log.
[[nodiscard]] std::vector<DrivenSample> driven_samples(const LogChains& chains, const DriveRecording& recording,
                                                       std::size_t number,
                                                       const std::vector<std::optional<LogPlace>>& places);

/// Standard deviation of a sample's mean when errors within `correlation_s` are one error: samples in a row count as
/// often as there are independent errors.
[[nodiscard]] double sigma_of_mean(double sigma, double correlation_s, const DrivenSample& sample);

}  // namespace orthodrive::elevate
