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
  explicit LogMatcher(const RoadNetwork& roads);
  ~LogMatcher();
  /// One-way roads are driven forward only. Linear in the length of the recording.
  [[nodiscard]] MatchLogResult match(const DriveRecording& recording, const std::string& name) const;

 private:
  struct Roads;
  const RoadNetwork& network_;
  std::unique_ptr<Roads> roads_;
};

}  // namespace orthodrive
