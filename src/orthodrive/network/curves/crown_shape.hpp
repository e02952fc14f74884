// SPDX-License-Identifier: Apache-2.0
#pragma once
// A crown that changes along a road as few <shape> entries of OpenDRIVE.

#include <span>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// The halves of a road that carry lanes.
enum class RoadHalves { both, left, right };

struct CrownShapeOptions {
  double fall_tolerance = 1e-4;  ///< m/m, largest error of the fall of a half
  /// 1/m, largest jump of the fall's slope at an entry: 0.1 % of gradient, 4 m off the reference line. At 40 m/s a
  /// wheel gets 0.04 m/s from it.
  double max_rate_jump = 2.5e-4;
  RoadHalves halves = RoadHalves::both;  ///< one half needs one entry a place: the plane goes on beyond the middle
};

/// Two straight halves that fall away from the reference line by `fall` (m/m, cubics of s that join C1): h(t) =
/// -fall |t|. Shapes are linear in s between their entries (1.7, 9.4.3): the fewest entries on the cubics (rounded to
/// 1e-5) between which the straight line keeps the tolerance and the slope jumps by at most the largest jump. At both
/// ends of the road it leaves the cubic's own slope by at most half of that, so roads that follow each other keep it,
/// too, and both have the cubic's fall at their joint. Empty for no fall, one place for a constant one.
[[nodiscard]] std::vector<roadquery::ShapeCubic> crown_shape(std::span<const roadquery::Cubic> fall, double length_m,
                                                             const CrownShapeOptions& options = {});

/// The largest jump that gives a wheel no more at a road's speed limit than the default does at 40 m/s.
[[nodiscard]] double max_rate_jump_of(const roadquery::Road& road);

/// Gives a road that has its lanes a crown as lateral shapes, where it has lanes, and leaves out joints of its
/// superelevation and elevation. Each takes its share of `tolerance_m`, by which heights move at most.
void add_crown(roadquery::Road& road, std::span<const roadquery::Cubic> fall, double tolerance_m,
               double max_rate_jump = CrownShapeOptions{}.max_rate_jump);

}  // namespace orthodrive::network
