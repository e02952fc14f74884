// SPDX-License-Identifier: Apache-2.0
#pragma once
// Faults of profiles that need no truth: kinks, steps, clearance.

#include <cstddef>
#include <limits>

#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct ProfileKink {
  double size = 0.0;  ///< jump of dz/ds
  Vec2 where;
};

struct ProfileShape {
  /// Along the ways and from way to way where one goes on in the next. Inside a way from z and gradient of three nodes:
  /// a profile with a corner has the mean gradient in the node and others in the segments.
  ProfileKink along;
  /// Of any road at a junction from the plane that fits all of them best.
  ProfileKink junction;
  ProfileKink step_m;  ///< between the heights of ways that share a node; size in metres
  std::size_t junctions = 0;
  std::size_t crossings = 0;        ///< on two levels: of other layers, or a metre and more apart in height
  std::size_t level_crossings = 0;  ///< the others, mostly where lines of roads that meet overlap
  double min_clearance_m =
      std::numeric_limits<double>::quiet_NaN();  ///< at the crossings on two levels, NaN without any
};

/// Nodes without height count for nothing.
[[nodiscard]] ProfileShape measure_profile_shape(const RoadNetwork& roads, const ScoreRegion& region = {});

}  // namespace orthodrive
