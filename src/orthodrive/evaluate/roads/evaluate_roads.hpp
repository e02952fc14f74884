// SPDX-License-Identifier: Apache-2.0
#pragma once
// How well roads lie on the true carriageways: area, centre line, width, and whether the stated uncertainty is right.

#include <optional>
#include <string>
#include <vector>

#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/evaluate/roads/path_shape.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

struct TruthSurface {
  std::string id;
  MultiPolygon polygons;
};
struct TruthLine {
  std::string of;  ///< id of the surface whose width counts; empty: any surface under the line
  Polyline line;
  std::vector<double> width_m;  ///< one per point; empty: measured across the surface
};
struct RoadTruth {
  std::vector<TruthSurface> surfaces;
  std::vector<TruthLine> lines;  ///< may be empty: then only the surface is scored
};
/// A network as truth: surfaces and lines with their widths, in the CRS asked for.
[[nodiscard]] RoadTruth road_truth(const RoadNetwork& roads, const Crs& crs);

struct EvaluateRoadsOptions {
  ScoreRegion region;   ///< in the CRS of the roads
  double step_m = 2.0;  ///< between samples along truth lines
  /// The roads before refinement, in the same CRS: adds moved_away. Must live as long as the call.
  const RoadNetwork* before = nullptr;
};

/// Places on truth lines that had a road before: at how many of them it is further away from the truth now? A place
/// whose road is out of reach now counts as both. Moves of less than a millimetre are none.
struct MovedAway {
  double share = 0.0, share_by_more_than_0_3_m = 0.0;  ///< NaN without a place
  std::size_t n = 0;                                   ///< places that had a road before
};

/// A place on a truth line and what was found there. NaN: nothing.
struct RoadPlace {
  std::size_t line = 0;  ///< of the truth
  Vec2 p;
  double offset_m = 0.0, width_error_m = 0.0;
  double offset_before_m = 0.0;
  double sigma_offset_m = 0.0, sigma_width_m = 0.0;  ///< as the road there states them
};

struct RoadScores {
  double surface_iou = 0.0;  ///< NaN without surfaces on both sides
  ErrorSummary offset_m;     ///< from each truth line across to the nearest road line, positive to its left
  ErrorSummary width_m;      ///< at the same places
  ErrorSummary edge_m;       ///< of the left and the right edge there, by offset and width
  double length_m = 0.0, truth_length_m = 0.0;  ///< of our lines and of the truth's, inside the area
  /// surface_iou without our ways that the truth does not know: those that, before refinement, ran along truth lines
  /// (within 6 m and 30 degrees) for less than half of their length. NaN without EvaluateRoadsOptions::before.
  double surface_iou_of_known_ways = 0.0;
  SigmaCoverage offset_sigma, width_sigma;
  std::size_t samples = 0;              ///< places on truth lines that were asked
  double matched_share = 0.0;           ///< of them with a road within reach
  double width_variance_m2 = 0.0;       ///< mean over our paths, eq. 3.11 of the reference; needs no truth
  CurvatureJump curvature_jump;         ///< largest along our paths; needs no truth
  std::optional<MovedAway> moved_away;  ///< with EvaluateRoadsOptions::before only
  std::vector<RoadPlace> places;        ///< one a sample, along line after line
};

/// Truth in the CRS of the roads. A road matches where it runs within 30 degrees of the truth line.
[[nodiscard]] RoadScores evaluate_roads(const RoadNetwork& roads, const RoadTruth& truth,
                                        const EvaluateRoadsOptions& options = {});

/// The carriageways, polygons that may overlap each other.
[[nodiscard]] std::vector<Polygon> surface_polygons(const RoadNetwork& roads);
[[nodiscard]] std::vector<Polygon> surface_polygons(const RoadTruth& truth);

/// Road surface that is wrong, as polygons that do not overlap; truth in the CRS of the roads.
struct SurfaceErrors {
  MultiPolygon false_positive;  ///< ours alone
  MultiPolygon false_negative;  ///< the truth's alone
};
[[nodiscard]] SurfaceErrors surface_errors(const RoadNetwork& roads, const RoadTruth& truth,
                                           const ScoreRegion& region = {});

}  // namespace orthodrive
