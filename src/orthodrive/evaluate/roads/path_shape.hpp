// SPDX-License-Identifier: Apache-2.0
#pragma once
// How smooth paths are, whatever the truth: the variance of their width and the jumps of their curvature.

#include <cstdint>

#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Where the curvature of a network's paths jumps most. NaN and no place when all paths are too short to have one.
struct CurvatureJump {
  double per_m = 0.0;       ///< 1/m, without sign
  std::int64_t osm_id = 0;  ///< the way
  Vec2 where;
  double mean_per_m = 0.0;  ///< mean over the paths of the largest jump along each
};

namespace evaluate {

/// Mean over the paths of sigma^2 = sum (X - mu)^2 / N of the widths X at a path's nodes (eq. 3.11 of "From Aerial
/// Images to Virtual Driving Environments", 2016), in m^2. Nodes outside the region do not count, nor do paths with
/// fewer than two inside. NaN without any path.
[[nodiscard]] double width_variance_m2(const RoadNetwork& roads, const ScoreRegion& region);

/// Every path is resampled to `step_m` along its length, so that lines with few nodes and with many compare: an OSM
/// corner of angle a is a curvature of a / step_m there. The curvature at a sample is its signed turn over the step; a
/// jump is the difference between samples two steps apart, because a step of the curvature between two samples spreads
/// over both (of a clean step at least 7/8 are seen). Closed paths are taken round. A path needs four steps.
[[nodiscard]] CurvatureJump largest_curvature_jump(const RoadNetwork& roads, const ScoreRegion& region, double step_m);

}  // namespace evaluate
}  // namespace orthodrive
