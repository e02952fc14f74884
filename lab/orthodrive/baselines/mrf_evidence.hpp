// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the MRF sees: three numbers a pixel, read tile by tile, and their sums across each road segment.

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "orthodrive/baselines/edge_distance.hpp"
#include "orthodrive/baselines/road_forest.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/model/rasters/photo_source.hpp"

namespace orthodrive {

/// Of the pixels of a box, one channel each.
struct MrfEvidence {
  Raster<std::uint8_t> non_road;     ///< probability that it is no road, 0..255 = 0..1: a cost inside a road
  Raster<std::uint8_t> road_beside;  ///< probability that it is road and not what lies beside one: a cost beside a road
  Raster<std::uint8_t> edge_distance;  ///< to the nearest edge, 255 = edge_cap_m: a cost along the borders
  Raster<std::uint8_t> valid;          ///< 0: nothing is known here
};

struct MrfEvidenceSource {
  Crs crs;
  GridFrame frame;
  double edge_cap_m = 2.0;
  /// Any box, also beyond the frame. From several threads at once. A pixel is the same in every box that has it.
  std::function<MrfEvidence(const PixelBox&)> read;
};

/// Of a photo: the road forest inside, the context forest beside, Canny along the borders. All three must outlive the
/// source.
[[nodiscard]] MrfEvidenceSource mrf_photo_evidence(const PhotoSource& photo, const RoadForests& forests,
                                                   const EdgeDistanceOptions& options = {});

/// The strip to each side of a straight segment that is looked at.
struct ProfileStrip {
  Vec2 a, b;           ///< ends of the segment
  Vec2 normal;         ///< unit, to the left of a -> b
  int half_knots = 0;  ///< knots to each side
  bool wanted = true;  ///< false: nothing is read, seen is 0
};

/// Means along a segment as functions of the lateral position t = (k - half_knots) * step_m, left positive. Sums run
/// from the rightmost knot, in metres, so that the cost between two knots is a difference.
struct CrossSums {
  int half_knots = 0;
  double seen = 0.0;              ///< share of the strip with valid pixels
  std::vector<float> non_road_m;  ///< running sum of the probability; unknown pixels count a half
  std::vector<float> road_beside_m;
  std::vector<float> edge_m;  ///< mean distance to an edge at the knot; unknown: half the cap
};

struct CrossSumOptions {
  double step_m = 0.25;  ///< between knots
  int threads = 0;
};

/// Each tile of the source that a strip touches is read once and by one thread; sums are of integers, so that their
/// order does not matter. Memory is linear in the number of strips, not in the area.
[[nodiscard]] std::vector<CrossSums> sum_across(std::span<const ProfileStrip> strips, const MrfEvidenceSource& source,
                                                const CrossSumOptions& options, Monitor* monitor = nullptr);

}  // namespace orthodrive
