#pragma once
// What a build will cost, estimated before it starts: from area, pixels and road length by a table of measured costs.

#include <string>
#include <vector>

#include "orthodrive/pipeline/site.hpp"

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
  double seconds = 0.0;
  double memory_mb = 0.0;  ///< largest of the stages: one runs at a time
  double disk_mb = 0.0;
};
/// On a machine like the one that was measured, with nothing else on it. `threads`: 0 = all cores.
[[nodiscard]] BuildEstimate estimate_build(const SiteSize& size, int threads = 0);

/// The machine that the costs were measured on: "2 cores (Intel Xeon)".
[[nodiscard]] std::string machine_of_costs();

}  // namespace orthodrive
