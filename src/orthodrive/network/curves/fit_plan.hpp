// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reference lines: lines, arcs and clothoids (OpenDRIVE's spirals) that join without gap, kink or jump of curvature
// (G2) beside a dense line of points.
//
// A clothoid spline (clothoid.hpp) through the smoothed points is the start. Then joints are taken out as long as every
// point stays within the tolerance, the pieces around being fitted anew each time, their lengths too
// (clothoid_chain.hpp); what is straight or round within the tolerance becomes a line or an arc. The result is short,
// not proven shortest.

#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

struct FitPlanOptions {
  double tolerance_m = 0.05;
  bool closed = false;  ///< the last point repeats the first and the line goes on there
  /// Bound of |d curvature / ds| in 1/m^2. The line through the points may need more at a sharp corner: then it is not
  /// made worse there.
  double max_curvature_rate = 0.25;
  std::span<const double> max_curvature;  ///< bound of |curvature| in 1/m, one per point, likewise; empty: none
};

struct PlanFit {
  std::vector<roadquery::PlanElement> elements;
  std::vector<double> point_s;  ///< of the points' feet on the line, not decreasing; 0 and its length for the ends
  double max_deviation_m = 0.0, mean_deviation_m = 0.0;
  std::size_t farthest_point = 0;
  bool clothoids = true;  ///< false: none were found, cubics (ParamPoly3) go through all points
};

/// At least two points, neighbours at different places.
[[nodiscard]] PlanFit fit_plan(std::span<const Vec2> points, const FitPlanOptions& options = {});

/// The biarc from one pose to another as one or two elements, s from 0; four where the target lies behind and looks the
/// same way. The poses' places differ.
struct Pose {
  Vec2 p, direction;  ///< unit vector
};
[[nodiscard]] std::vector<roadquery::PlanElement> biarc(const Pose& from, const Pose& to);
/// For connecting roads: the one clothoid between the poses (clothoid.hpp), or their biarc where the clothoid is a
/// detour or more than twice as sharp.
[[nodiscard]] std::vector<roadquery::PlanElement> turn(const Pose& from, const Pose& to);

/// Element lists ("plans") start at s = 0. The part from s0 to s1, again from 0.
[[nodiscard]] std::vector<roadquery::PlanElement> slice_plan(std::span<const roadquery::PlanElement> plan, double s0,
                                                             double s1);
/// The same line walked from its end to its start.
[[nodiscard]] std::vector<roadquery::PlanElement> reverse_plan(std::span<const roadquery::PlanElement> plan);
[[nodiscard]] double plan_length(std::span<const roadquery::PlanElement> plan);
[[nodiscard]] Pose pose_at(std::span<const roadquery::PlanElement> plan, double s);

}  // namespace orthodrive::network
