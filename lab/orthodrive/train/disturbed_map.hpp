// SPDX-License-Identifier: Apache-2.0
#pragma once
// A map as it might be wrong, made from the truth of a crop: what a network learns to align from.

#include <cstdint>

#include "orthodrive/model/rasters/allowed_classes.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"

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

/// Classes of what a map may show: roads, and what looks like one on it (aisles of car parks are ways of OSM, too).
struct MapClasses {
  ClassSet road = 0, maybe_road = 0;
};

/// What can only be `road` (one class or several) in the crop are thinned to their centre lines (Zhang and Suen, A fast
/// parallel algorithm for thinning digital patterns, 1984). Then they are moved by a smooth field (four waves of 40 to
/// 400 px, of up to 10 px each, now and then all by up to 16 px), get coarse nodes, wrong or no widths; some are left
/// out, others are invented, half of the time also along what is `maybe_road`. One map in ten is empty. Where there is
/// a `real` map (in the crop's pixels) half of the maps are that one, moved likewise: it shows what maps show, but
/// nothing true is known of its lines.
[[nodiscard]] DisturbedMap draw_map(const Raster<ClassSet>& allowed, const std::vector<RoadLine>& real,
                                    const MapClasses& classes, std::uint64_t seed);
/// The lines alone of a map that is made out of the crop.
[[nodiscard]] std::vector<RoadLine> draw_lines(const Raster<ClassSet>& allowed, const MapClasses& classes,
                                               std::uint64_t seed);

/// A real map, moved by such a field.
[[nodiscard]] std::vector<RoadLine> move_lines(const std::vector<RoadLine>& real, std::uint64_t seed);

/// Centre lines of the pixels that are not 0, in pixels, with half the width at each point; spurs and what is nowhere 3
/// px wide are left out. A width is
/// negative where its edge is not known: where the nearest other pixel is `unknown`, or the raster ends before it.
struct ThinnedLine {
  Polyline points;
  std::vector<double> half_width;
};
[[nodiscard]] std::vector<ThinnedLine> thinned_lines(const Raster<std::uint8_t>& mask,
                                                     const Raster<std::uint8_t>& unknown);

}  // namespace orthodrive
