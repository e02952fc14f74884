#pragma once
// How well roads lie on the true carriageways: area, centre line, width, and whether the stated uncertainty is right.

#include <string>
#include <vector>

#include "orthodrive/evaluate/scores.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/model/road_network.hpp"

namespace orthodrive {

struct TruthSurface {
  std::string id;
  MultiPolygon polygons;
};
struct TruthLine {
  std::string of;  ///< id of the surface whose width counts; empty: any surface under the line
  Polyline line;
  std::vector<double> width_m;  ///< one a point; empty: measured across the surface
};
struct RoadTruth {
  std::vector<TruthSurface> surfaces;
  std::vector<TruthLine> lines;  ///< may be empty: then only the surface is scored
};
/// A network as truth: surfaces and lines with their widths, in the CRS asked for.
[[nodiscard]] RoadTruth road_truth(const RoadNetwork& roads, const Crs& crs);

struct EvaluateRoadsOptions {
  ScoreRegion region;      ///< in the CRS of the roads
  double step_m = 2.0;     ///< between samples along truth lines
  double search_m = 15.0;  ///< a road further across than this is another road
};

/// Share of the errors within so many of the sigmas that the nearest node states. NaN where no node states any.
struct SigmaCoverage {
  double one = 0.0, two = 0.0;
};

struct RoadScores {
  double surface_iou = 0.0;  ///< NaN without surfaces on both sides
  ErrorSummary offset_m;     ///< from each truth line across to the nearest road line, positive to its left
  ErrorSummary width_m;      ///< at the same places
  SigmaCoverage offset_sigma, width_sigma;
  std::size_t samples = 0;     ///< places on truth lines that were asked
  double matched_share = 0.0;  ///< of them with a road within reach
};

/// Truth in the CRS of the roads. A road matches where it runs within 30 degrees of the truth line.
[[nodiscard]] RoadScores evaluate_roads(const RoadNetwork& roads, const RoadTruth& truth,
                                        const EvaluateRoadsOptions& options = {});

}  // namespace orthodrive
