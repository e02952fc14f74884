// SPDX-License-Identifier: Apache-2.0
#pragma once
// What `evaluate roads` writes to look at: a picture, and layers for QGIS.

#include <filesystem>

#include "orthodrive/evaluate/roads/evaluate_roads.hpp"

namespace orthodrive {

/// Roads, truth and region in one CRS; scores of exactly these.
struct ScoredRoadsView {
  const RoadNetwork& roads;
  const RoadTruth& truth;
  const ScoreRegion& region;
  const RoadScores& scores;
};

/// A PNG of picture_of_road_errors; without a photo (empty path) over even grey. Throws InputError when there is a
/// photo that does not show the place.
void write_road_overlay(const std::filesystem::path& path, const std::filesystem::path& photo,
                        const ScoredRoadsView& view);

/// A GeoPackage with the layers
/// - false_positive, false_negative: polygons with area_m2;
/// - truth_lines: the truth lines with mean_abs_offset_m, p95_offset_m, mean_abs_width_error_m and their places (n);
/// - truth_samples: every place asked, with line, offset_m, width_error_m, offset_before_m and the sigmas
///   that the road states there; null where nothing is.
void write_road_layers(const std::filesystem::path& path, const ScoredRoadsView& view);

}  // namespace orthodrive
