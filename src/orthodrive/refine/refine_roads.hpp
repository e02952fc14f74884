// SPDX-License-Identifier: Apache-2.0
#pragma once
// Moves OSM centre lines onto the road seen in the labels and measures the carriageway width.
//
// After the nonlinear optimisation of "From Aerial Images to Virtual Driving Environments" (2016), sec. 3.3: per node
// an offset along the normal of the path and a width; residuals r_c, r_a, r_w, r_o; Levenberg-Marquardt. Differences
// and their reasons: docs/refine.md. The thesis' own methods: baselines/.

#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/gps_traces.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/refined_roads.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive {

/// Weights of the residuals (docs/refine.md); prior knowledge is given as standard deviations.
struct RefineWeights {
  double evidence = 20.0;     ///< w_c, of the mean class cost in a strip
  double loss_scale = 1.5;    ///< of the Cauchy loss of w_c: residuals beyond are outliers
  double angle = 10.0;        ///< w_a, 1/rad
  double curvature = 80.0;    ///< w_k, 1/rad, of the change of the angle from node to node
  double width = 25.0;        ///< w_w, 1/m
  double offset = 0.3;        ///< w_o, 1/m
  double map_shift_m = 5.0;   ///< sigma of the shift of the map: OSM was traced from photos that lie elsewhere
  double way_shift_m = 0.2;   ///< sigma of the shift of a way beyond that of the map around it
  double node_shift_m = 0.2;  ///< sigma of a node's offset around the shift of its way
  double misplaced_sigmas =
      3.0;  ///< scale of the Cauchy loss of a node's shift and width: what is seen further off is so
  double node_width_share = 0.013;  ///< sigma of a node's width around the width of its way, as a share of it
  double input_width = 0.2;         ///< factor on the sigma of the input's width (road_chains.hpp)
  double seen_sigma = 1.0;          ///< factor on the sigmas of a network that sees the map
  double search_step = 0.2;  ///< of the search: cost of one level (0.5 m) from segment to segment, metres misclassified
  double search_offset_m = 3.0;     ///< of the search: this offset costs as much as one metre misclassified
  double search_width_share = 0.5;  ///< of the search: this change of the width costs the same
};

struct RefineRoadsOptions {
  double spacing_m = 2.0;         ///< paths are resampled to about this distance
  double search_radius_m = 8.0;   ///< largest offset to each side of the OSM line
  double strip_m = 1.5;           ///< width of the context and boundary strips: three pixels of the labels
  double min_width_factor = 0.5;  ///< bounds of the width, times the input's width
  double max_width_factor = 1.8;
  RefineWeights weights;
  DrivingSide driving_side = DrivingSide::right;  ///< where the traces come from
  int max_iterations = 60;
  int threads = 0;                   ///< 0 = all cores; the result does not depend on it
  LoopExchange* exchange = nullptr;  ///< with other processes that refine the same roads; nor on it
};

/// `osm`, `evidence` and `traces`, if there are any, share one CRS (throws OptionError). Paths outside the evidence
/// keep the OSM line, unless traces tell another. `alignment`: one per path, or empty: where a network sees the roads.
/// Time and memory are linear in the length of the roads.
[[nodiscard]] RefinedRoads refine_roads(const RoadNetwork& osm, const RoadEvidence& evidence,
                                        const RefineRoadsOptions& options = {}, Monitor* monitor = nullptr,
                                        const GpsTraces& traces = {}, const RoadAlignment& alignment = {});
/// The same with labels of probability 1.
[[nodiscard]] RefinedRoads refine_roads(const RoadNetwork& osm, const LabelMap& labels,
                                        const RefineRoadsOptions& options = {}, Monitor* monitor = nullptr,
                                        const GpsTraces& traces = {});

}  // namespace orthodrive
