// SPDX-License-Identifier: Apache-2.0
#pragma once
// The profile that drive logs correct: heights, gradients and banking of the nodes, read along a chain.

#include <cstddef>

#include "orthodrive/elevate/logs/fuse_drive_logs.hpp"
#include "orthodrive/roads/log_chains.hpp"

namespace orthodrive::elevate {

/// In the chain's direction.
struct GivenProfile {
  double z_m, gradient, banking_rad, banking_change, crown_rad, sigma_z_m, sigma_banking_rad;
};

/// Between two nodes: heights by the Hermite cubic of heights and gradients, all else linear.
[[nodiscard]] GivenProfile given_profile_at(const RoadNetwork& roads, const LogChains& chains, std::size_t chain,
                                            double along_m, const FuseDriveLogsOptions& options);

}  // namespace orthodrive::elevate
