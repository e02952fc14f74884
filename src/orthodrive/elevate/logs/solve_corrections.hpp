// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 7 of fuse_drive_logs: solves for the corrections and writes them with their standard deviations into the roads.

#include <vector>

#include "orthodrive/elevate/logs/fusion_problem.hpp"

namespace orthodrive::elevate {

struct Corrections {
  std::vector<double> x;  ///< the unknowns by FusionColumns
  WeightedRows rows;      ///< all rows around x, with their robust weights
  DriveResiduals residuals;
  SolveSummary solve;
};

/// Gauss-Newton with reweighting (Cauchy loss). Not linear are only the arctangent of the gradient, the robust weights,
/// and the specific force where no sensor felt it.
[[nodiscard]] Corrections solve_corrections(const FusionProblem& problem);

/// Corrects the nodes of all member chains; fills in driven nodes, calibration and residuals.
void write_corrections(const FusionProblem& problem, const Corrections& corrections, FuseDriveLogsResult& result);

}  // namespace orthodrive::elevate
