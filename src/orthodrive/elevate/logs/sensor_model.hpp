// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 6 of fuse_drive_logs: what sensors in a car measure of the road below it (docs/drive_logs.md).

#include <vector>

#include "orthodrive/elevate/logs/fusion_problem.hpp"

namespace orthodrive::elevate {

/// A measurement, linear around the present solution: sum of entries * x = value.
struct Measurement {
  Entries entries;
  double value = 0.0;
  double sigma = 1.0;                      ///< of one pose: scale of the robust loss
  double sigma_of_mean = 1.0;              ///< of the sample, which sets its weight
  double DriveResiduals::*kind = nullptr;  ///< where its residual is counted

  [[nodiscard]] double residual(const std::vector<double>& x) const;
};

/// Pitch, climb, height, roll and lateral force of a sample, as far as they were recorded, around the solution `x`.
[[nodiscard]] std::vector<Measurement> measurements_of(const FusionProblem& problem, const DrivenSample& sample,
                                                       const std::vector<double>& x);

/// Mounting, suspension and biases of each sensor; offset and drift of the heights of each recording.
void add_sensor_priors(const FusionProblem& problem, WeightedRows& rows);

}  // namespace orthodrive::elevate
