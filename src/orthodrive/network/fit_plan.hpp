#pragma once
// Reference lines: lines and arcs that join without gap or kink (G1) through a dense line of points.
//
// Pairs of arcs ("biarcs", Bolton 1975) are stretched over as many points as stay within the tolerance. Between points
// i and j with tangents there is one biarc with equal control lengths, in closed form; a straight one is a line. Long
// straights are found first and their ends get the straight's direction, so that noise does not turn them into arcs.

#include <span>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive::network {

struct FitPlanOptions {
  double tolerance_m = 0.05;
  bool closed = false;  ///< the last point repeats the first and the line goes on there
};

struct PlanFit {
  std::vector<roadquery::PlanElement> elements;  ///< Line and Arc only
  std::vector<double> point_s;                   ///< of the points' feet on the line, not decreasing
  double max_deviation_m = 0.0;
};

/// At least two points, neighbours at different places.
[[nodiscard]] PlanFit fit_plan(std::span<const Vec2> points, const FitPlanOptions& options = {});

/// The biarc from one pose to another as one or two elements, s from 0; four where the target lies behind and looks the
/// same way. The poses' places differ.
struct Pose {
  Vec2 p, direction;  ///< unit vector
};
[[nodiscard]] std::vector<roadquery::PlanElement> biarc(const Pose& from, const Pose& to);

/// Element lists ("plans") start at s = 0. The part from s0 to s1, again from 0.
[[nodiscard]] std::vector<roadquery::PlanElement> slice_plan(std::span<const roadquery::PlanElement> plan, double s0,
                                                             double s1);
/// The same line walked from its end to its start.
[[nodiscard]] std::vector<roadquery::PlanElement> reverse_plan(std::span<const roadquery::PlanElement> plan);
[[nodiscard]] double plan_length(std::span<const roadquery::PlanElement> plan);
[[nodiscard]] Pose pose_at(std::span<const roadquery::PlanElement> plan, double s);

}  // namespace orthodrive::network
