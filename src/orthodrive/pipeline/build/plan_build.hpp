// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a build will cost, estimated before it starts: from area, pixels and road length by a table of measured costs.

#include <string>
#include <vector>

#include "orthodrive/pipeline/build/machine_speed.hpp"
#include "orthodrive/pipeline/sources/site.hpp"

namespace orthodrive {

/// What the cost of a stage grows with.
struct SiteSize {
  double area_km2 = 0.0;
  double megapixels = 0.0;  ///< of the photo over the bounds of the area, at its own ground sampling distance
  double road_km = 0.0;     ///< of drivable ways of the map
};
/// Reads the photo's header and the map. Throws InputError when they cannot be read.
[[nodiscard]] SiteSize size_of(const Site& site);

struct StageEstimate {
  std::string stage;
  double seconds = 0.0;
  double memory_mb = 0.0;  ///< peak
  double disk_mb = 0.0;    ///< what it leaves
};
struct BuildEstimate {
  std::vector<StageEstimate> stages;
  double speed = 0.0;  ///< of this machine over that of the costs, with as many threads as either has
  double seconds = 0.0;
  double memory_mb = 0.0;  ///< largest of the stages: one runs at a time
  double disk_mb = 0.0;
};
/// On a machine of that speed, from nothing.
[[nodiscard]] BuildEstimate estimate_build(const SiteSize& size, const MachineSpeed& machine);

/// The machine that the costs were measured on: "2 cores (AMD EPYC)".
[[nodiscard]] std::string machine_of_costs();

}  // namespace orthodrive
