#pragma once
// A map as it might be wrong, made from the truth of a crop: what a network learns to align from.

#include <cstdint>

#include "orthodrive/model/allowed_classes.hpp"
#include "orthodrive/model/map_alignment.hpp"

namespace orthodrive {

/// What the map says of a pixel's nearest line, and what is true of it. In pixels.
struct AlignmentTruth {
  float normal_x = 0.0F, normal_y = 0.0F;  ///< unit normal of the line
  float offset = 0.0F;                     ///< of the true centre line from the pixel's centre, along the normal
  float half_width = 0.0F;
  bool known = false;  ///< a line without known edges has no known place
};

struct DisturbedMap {
  Raster<std::uint8_t> map;      ///< map_raster
  Raster<AlignmentTruth> truth;  ///< of the pixels within 12 px of a line
};

/// The roads that can only be `road` in the crop are thinned to their centre lines (Zhang and Suen, A fast parallel
/// algorithm for thinning digital patterns, 1984). Then they are moved by a smooth field (four waves of 40 to 400 px,
/// of up to 6 px each, now and then all by up to 16 px), get coarse nodes, wrong or no widths; some are left out,
/// others are invented.
[[nodiscard]] DisturbedMap draw_map(const Raster<ClassSet>& allowed, ClassSet road, std::uint64_t seed);

/// Centre lines of the pixels that are not 0, in pixels, with half the width at each point; spurs and what is nowhere 3
/// px wide are left out. A width
/// is negative where its edge is not known: where the nearest other pixel is `unknown`, or the raster ends before it.
struct ThinnedLine {
  Polyline points;
  std::vector<double> half_width;
};
[[nodiscard]] std::vector<ThinnedLine> thinned_lines(const Raster<std::uint8_t>& mask,
                                                     const Raster<std::uint8_t>& unknown);

}  // namespace orthodrive
