// SPDX-License-Identifier: Apache-2.0
#pragma once
// One path of the baseline (nlo_roads.hpp): resampling, the least-squares problem, the curvature filter.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "orthodrive/baselines/label_strips.hpp"
#include "orthodrive/baselines/nlo_roads.hpp"
#include "orthodrive/model/roads/solve_summary.hpp"

namespace orthodrive::baselines {

struct NloNode {
  Vec2 base;                  ///< on the OSM line
  Vec2 normal;                ///< unit, to the left of the path
  std::int64_t osm_node = 0;  ///< 0: put in by resampling
  double width_m = 0.0;       ///< of the input
  std::size_t own = 0;  ///< the node whose offset and width are this one's: itself, or an earlier one at its place
};

struct NloPath {
  std::vector<NloNode> nodes;
  bool closed = false;  ///< the last node is the first
};
/// Divides what is between two OSM nodes into about `spacing_m`; normals are those of the bisectors.
[[nodiscard]] NloPath resample_for_nlo(const RoadPath& path, double spacing_m);

struct NloFit {
  std::vector<double> offset_m, width_m;  ///< one per node
  SolveSummary solve;
  bool outside_labels = false;  ///< nothing to see along the whole path: the input as it is
  bool failed = false;          ///< the solver could not go on; the values are those before
};
/// All passes of the options. One thread, no randomness: the same result everywhere.
[[nodiscard]] NloFit fit_nlo(const NloPath& path, const LabelMap& labels, const NloRoadsOptions& options);

/// Lowers the peaks of the curvature: "further reduces the energy of the roads' curvature by applying a model-based
/// filtering similar to the process described in section 3.4" (sec. 4.1). That model with the curvature k in the place
/// of the gradient and the offset in that of the height: w_g k, w_v (k_n - k_(n-1)), w_e (offset - offset before) under
/// a Cauchy loss of scale 0.5, with the weights of sec. 3.4. The thesis gives no more.
void filter_curvature(const NloPath& path, std::vector<double>& offset_m);

}  // namespace orthodrive::baselines
