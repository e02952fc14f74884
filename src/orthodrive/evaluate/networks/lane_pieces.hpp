// SPDX-License-Identifier: Apache-2.0
#pragma once
// Driving lanes in driving direction and where each leads, for judge_network.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "roadquery/roads/road_ends.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::evaluate {

/// A driving lane of one lane section, in driving direction.
struct LanePiece {
  const roadquery::Road* road = nullptr;
  std::size_t section = 0;
  const roadquery::Lane* lane = nullptr;
  double s_begin = 0.0, s_end = 0.0;  ///< of the section
  bool forward = true;                ///< driven along s
  std::vector<std::size_t> next;      ///< indices of the pieces that it leads to

  [[nodiscard]] double length() const { return s_end - s_begin; }
  /// Rounding must not lead out of the section: profiles are 0 before their first s.
  [[nodiscard]] double s_at(double driven_m) const {
    return std::clamp(forward ? s_begin + driven_m : s_end - driven_m, s_begin, s_end);
  }
};

/// All of a map, those of one road together, each with its links.
[[nodiscard]] std::vector<LanePiece> lane_pieces(const roadquery::RoadMap& map, const roadquery::RoadsById& by_id);

/// A place of a lane, seen in driving direction.
struct LanePlace {
  roadquery::PlanPoint reference;  ///< of the road, at the same s
  double centre_t = 0.0;           ///< t of the middle of the lane
  double width_m = 0.0;
  double heading_rad = 0.0;  ///< of the middle
  double curvature = 0.0;    ///< of the middle, 1/m, positive = left turn
};
/// At a place of the piece's road, s_begin <= s <= s_end. The heading follows the lane as its borders move.
[[nodiscard]] LanePlace lane_place(const LanePiece& piece, double s);

}  // namespace orthodrive::evaluate
