// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which road a drive was on: map matching by a hidden Markov model.
//
// After Newson and Krumm, Hidden Markov map matching through noise and sparseness, ACM GIS 2009: the probability of a
// position given a place on a road (eq. 1), of the way between two places given the distance of the positions (eq. 2),
// the most probable sequence by Viterbi's algorithm. What differs: states have a direction of travel, the heading is
// observed too (parallel roads, ramps), and "on no road" is a state instead of a break.

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/drive_log.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct MatchLogOptions {
  double spacing_m = 10.0;            ///< between matched poses; the others are placed on the way between them
  double lateral_sigma_m = 2.5;       ///< of a car beside the centre line: lanes, and the error of the line itself
  double heading_sigma_rad = 0.3;     ///< of the direction of travel to that of the road
  double detour_m = 3.0;              ///< beta of eq. 2: mean difference between the way on roads and the straight line
  double no_road_sigmas = 3.5;        ///< beyond this many standard deviations "on no road" is more probable
  double unmatched_finding_m = 50.0;  ///< a stretch without road of this length is reported
  double slowest_heading_mps = 1.5;   ///< below, positions give no direction of travel
};

/// A pose on a road.
struct LogPlace {
  std::size_t path = 0;
  double s_m = 0.0;       ///< along the path
  double offset_m = 0.0;  ///< of the car, positive to the left of the path's direction
  bool forward = true;    ///< driven in the path's direction
};

struct MatchLogResult {
  std::vector<std::optional<LogPlace>> places;  ///< [pose]; none: on no road
  double length_m = 0.0, matched_m = 0.0;       ///< of the recording, and of its part on roads
  Findings findings;                            ///< "drive_log.no_match" (all of it), "drive_log.unmatched" (a stretch)
};

/// The roads under a network, prepared once for many recordings.
class LogMatcher {
 public:
  /// Keeps a reference to the roads. Needs s_m of the nodes to ascend, as every stage leaves it.
  explicit LogMatcher(const RoadNetwork& roads, const MatchLogOptions& options = {});
  ~LogMatcher();
  /// One-way roads are driven forward only. Linear in the length of the recording.
  [[nodiscard]] MatchLogResult match(const DriveRecording& recording, const std::string& name) const;

 private:
  struct Roads;
  const RoadNetwork& network_;
  MatchLogOptions options_;
  std::unique_ptr<Roads> roads_;
};

}  // namespace orthodrive
