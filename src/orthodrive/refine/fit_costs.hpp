// SPDX-License-Identifier: Apache-2.0
#pragma once
// The residuals of fit_chain as Ceres cost functions, each with its analytic derivatives. Equations of "From Aerial
// Images to Virtual Driving Environments" (2016), sec. 3.3.2, and docs/refine.md.
//
// Ceres owns what these functions return.

#include <array>
#include <cstddef>

#include "orthodrive/geo/vec.hpp"
#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace ceres {
class CostFunction;
}

namespace orthodrive::refine {

/// Classification residual r_c, eq. 3.3: left and right context strip, left and right boundary strip of a segment.
/// Unknowns: offset and width of the node before it, offset and width of the node behind it. `strips` and `profiles`
/// must outlive it.
[[nodiscard]] ceres::CostFunction* classification_cost(const StripCosts& strips, const CrossProfiles& profiles,
                                                       std::size_t segment, double weight);
/// Angle variation r_a, eq. 3.8: the angle between two segments. Unknowns: the offsets of their three nodes.
[[nodiscard]] ceres::CostFunction* angle_cost(const std::array<const ChainNode*, 3>& nodes, double weight);
/// Curvature variation r_k: how much the angle changes from one node to the next. Unknowns: the offsets of four nodes.
[[nodiscard]] ceres::CostFunction* curvature_change_cost(const std::array<const ChainNode*, 4>& nodes, double weight);
/// Width and offset variation r_w and r_o, eq. 3.9 and 3.10: weight * (second unknown - first).
[[nodiscard]] ceres::CostFunction* difference_cost(double weight);
/// (unknown - value) / sigma
[[nodiscard]] ceres::CostFunction* prior_cost(double value, double sigma);
/// How far an edge is beyond its limit: the left one (side +1) or the right one (-1). Unknowns: offset, width.
[[nodiscard]] ceres::CostFunction* limit_cost(double side, double edge_m, double weight);

/// weight * shift. Unknown: a shift in x and y.
[[nodiscard]] ceres::CostFunction* shift_prior_cost(double weight);
/// weight * (offset - expected offset - normal . shift). Unknowns: the shift of a way, the offset of a node.
[[nodiscard]] ceres::CostFunction* node_shift_cost(Vec2 normal, double expected_m, double weight);

/// (offset - told offset - normal . common error) / sigma of a trace's own scatter. Unknowns: the offset, and the
/// common errors at the knots before and after, in units of before_m and after_m.
[[nodiscard]] ceres::CostFunction* trace_cost(Vec2 normal, double told_m, double before_m, double after_m,
                                              double sigma_m);
/// The common error at one knot by that of the knot before: a Gauss-Markov process of unit variance.
[[nodiscard]] ceres::CostFunction* trace_drift_cost(double correlation);

}  // namespace orthodrive::refine
