// SPDX-License-Identifier: Apache-2.0
#pragma once
// The baseline: the nonlinear optimisation of "From Aerial Images to Virtual Driving Environments" (2016), sec. 3.3.2
// and 3.3.3, as published. refine_roads is the default method; this one is for comparison.
//
// One OSM way is one path, solved on its own. Per node an offset along the normal of the path and a width. Residuals,
// all squared without a loss:
//   r_c = w_c sum(c d) / sum(d)         eq. 3.3, twice a segment: context strips outside (left and right together) and
//                                       boundary strips inside, by counting the pixels of the labels
//   r_a = w_a atan2(|v1 x v2|, v1.v2)   eq. 3.8, between consecutive segments
//   r_w = w_w (width_n - width_(n-1))   eq. 3.9, every segment
//   r_o = w_o (offset_n - offset_(n-1)) eq. 3.10, every segment
// Levenberg-Marquardt (Ceres); r_c is differentiated numerically, the others automatically, as in sec. 3.3.1.
//
// What the thesis leaves open, and what is taken here:
// - d (figure 3.6, no numbers given) rises linearly from 0 at the border to 1 at the far edge of the strip.
// - The step of the numeric derivatives is that of Ceres (`difference_step_m`, see there); differences are central.
// - A further pass starts from the offsets and widths of the one before, on the same normals, with a fresh trust
// region.
// - Resampling keeps every OSM node and divides what is between two of them evenly.
// - A closed way stays closed: its last node is its first. Nodes at one place have one offset and one width.
// - Offsets and widths have bounds, which the solver keeps. Without them nothing holds a node of set 2 back: an angle
//   costs at most pi, w_o is 0, and a strip without any road costs the same wherever it lies. The thesis calls the map
//   "already quite close to the optimum solution" (sec. 3.3.2).
// - What has no label is no road (table 3.2, "other"), also beyond the raster: sec. 3.3 has labels everywhere. Nodes
//   without a label in any strip beside them keep the OSM line.

#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/refined_roads.hpp"

namespace orthodrive {

/// A run of the solver with one set of weights.
struct NloPass {
  double weight_class = 10.0;  ///< w_c
  double weight_angle = 1.0;   ///< w_a, 1/rad
  double weight_width = 0.2;   ///< w_w, 1/m
  double weight_offset = 0.2;  ///< w_o, 1/m
  int max_iterations = 20;
};
/// Table 3.3 of the thesis: near to the labels, and smooth. Its best is one after the other (table 3.4).
inline constexpr NloPass nlo_set_1{10.0, 1.0, 0.2, 0.2, 20}, nlo_set_2{10.0, 20.0, 10.0, 0.0, 20};

struct NloRoadsOptions {
  std::vector<NloPass> passes{nlo_set_1, nlo_set_2};
  double spacing_m = 2.0;  ///< paths are resampled to about this distance
  double strip_m = 1.25;   ///< width of the context and boundary strips: 16 px of the thesis' photo
  /// Half the distance of the two counts of a central difference. So small (Ceres' own: 1e-6 of the parameter) that no
  /// pixel enters or leaves a strip in between: what is seen is how d of the counted pixels changes as the border
  /// moves, which pulls the border over misclassified pixels even where a whole strip is wrong. Steps of pixels see the
  /// jumps of the count instead and are worse: on a straight road of 6 m (0.2 m/px) 2 m off, set 1 ends 0.004 m off
  /// with 1e-6, 0.92 m with 0.1, 0.29 m with 0.25 and 0.46 m with 0.5.
  double difference_step_m = 1e-6;
  double max_offset_m = 5.0;                              ///< bounds: offsets reach so far to both sides,
  double min_width_factor = 0.5, max_width_factor = 2.0;  ///< and widths from this to that many times the input's
  double unlabelled_cost = 1.0;  ///< of a pixel without a label inside the road, 0 to 1; outside it costs nothing
  bool filter_and_join = false;  ///< the two extras of the thesis' example (sec. 4.1): curvature filter, then junctions
  int threads = 0;               ///< 0 = all cores; the result does not depend on it
};

/// `osm` and `labels` share one CRS; every node has a width (both: OptionError). The result has the input's paths,
/// resampled; sigmas are 0: the method states none. Without filter_and_join paths that share an OSM node may come apart
/// there, each with its own offset. Cost in the summary: that of the last pass, at the input and at the result.
/// Findings: "refine.outside_labels", "refine.no_length", "refine.solver_failed".
[[nodiscard]] RefinedRoads refine_roads_nlo(const RoadNetwork& osm, const LabelMap& labels,
                                            const NloRoadsOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive
