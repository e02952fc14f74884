// SPDX-License-Identifier: Apache-2.0
#pragma once
// Banking and crown of roads: measured across the carriageway where the terrain model is fine enough, else as roads are
// designed. The surface that it describes: z(t) = z + t tan(banking) - |t| tan(crown), t positive to the left.
// docs/banking.md.

#include <span>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct BankingOptions {
  double coarsest_gsd_m = 2.0;  ///< coarser terrain models do not show banking
  double design_crown =
      0.025;  ///< slope of both halves of a straight road (RASt 06, RAL 2012), where nothing is measured
  double largest_slope = 0.08;                    ///< |tan(banking)| of public roads (RAL 2012: 7 %, exceptions 8 %)
  DrivingSide driving_side = DrivingSide::right;  ///< one-way carriageways fall to that side
  double terrain_sigma_m = 0.05;  ///< noise of a terrain pixel to begin with; the pixels of a road correct it
  /// Where roads meet, all of them lie in the plane of their gradients there, the most important one too: for heights
  /// that were fitted with such planes.
  bool in_junction_planes = false;
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
};

struct EstimateBankingResult {
  RoadNetwork roads;            ///< banking, crown, banking_source, sigma_banking of every node
  Findings findings;            ///< "elevate.banking_limit": measured beyond the limit
  double measured_share = 0.0;  ///< of the nodes, with banking_source "dtm"
};

/// `roads` have heights; nodes without get the design's banking. Sources: "dtm" measured, "interpolated" between or
/// shortly beyond measured places (bridges, junctions), "design", "none" (raceways that nothing measured). Continuous
/// along chains (model/path_links); where a way ends at or crosses a higher ranked one it lies in that one's plane. The
/// limits of slopes do not hold there: a road that crosses a steep one is banked by its gradient.
/// Throws OptionError when a terrain model has another CRS than the roads. Linear in road length.
[[nodiscard]] EstimateBankingResult estimate_banking(const RoadNetwork& roads, std::span<const HeightGrid> dtms,
                                                     const BankingOptions& options = {});

}  // namespace orthodrive
