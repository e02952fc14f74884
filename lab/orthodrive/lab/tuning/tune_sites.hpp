// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sites that `orthodrive tune` searches weights on, and how far refined roads are from the truth there.
//
// The file (TOML, paths relative to it):
//   [[site]]
//   name = "kvarnbyn"
//   labels = "labels.tif"                       # gives area and CRS
//   road_probability = "road_probability.tif"   # optional, on the grid of the labels
//   osm = "roads.osm"
//   truth = "carriageways.geojson"              # in the forms of `evaluate roads`; with centre lines
//   area = "area.geojson"                       # optional: polygons that limit the score
//   ignore = "unmapped.geojson"                 # optional: polygons taken out of the score
//   pieces = true                               # optional: each feature of `area` is a site of its own
//   fold = "Sweden"                             # optional, default the name: sites of one fold are held out together

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

struct TuneSite {
  std::string name, fold;
  std::size_t evidence = 0;  ///< index in TuneSites::evidence: pieces share it
  RoadNetwork osm;           ///< with an area: only ways that come within 150 m of it, each as a whole
  RoadTruth truth;
  ScoreRegion region;
};
struct TuneSites {
  std::vector<RoadEvidence> evidence;
  std::vector<TuneSite> sites;
};

/// Pieces that do not lie in the labels as a whole are another photo's: left out, and `monitor` told. So are pieces
/// without a centre line or without roads. Throws InputError with the line of the file for unknown keys, missing files,
/// names that are there twice, and sites of which nothing is left.
[[nodiscard]] TuneSites read_tune_sites(const std::filesystem::path& file, Monitor* monitor = nullptr);

/// How far roads are from the truth of a site. Terms that the truth cannot tell (no surfaces, no widths) are NaN and
/// not in the loss; NaN as a whole without a place on a truth line.
struct RoadLoss {
  double offset_m = 0.0;  ///< mean over the places on truth lines; 8 m at most, and where no road is near
  double width_m = 0.0;   ///< mean absolute error
  double surface_iou = 0.0;
  double unmatched_share = 0.0;  ///< of the places: no road is near
  /// offset + width / 2 + (1 - IoU) 1 m. An edge of the road is off by at most the offset and half the width's error;
  /// the IoU sees what no centre line tells: mouths of junctions and roads where there is none.
  double loss_m = 0.0;
};
[[nodiscard]] RoadLoss road_loss(const RoadNetwork& roads, const TuneSite& site);

}  // namespace orthodrive
