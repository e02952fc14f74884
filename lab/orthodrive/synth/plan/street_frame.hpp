// SPDX-License-Identifier: Apache-2.0
#pragma once
// A frame turned about the site's middle, in which grids and woven lanes are planned, and joints on exact curves.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "orthodrive/synth/plan/planner.hpp"

namespace orthodrive::synth {

class StreetFrame {
 public:
  StreetFrame(double size_m, double turn_rad)
      : size_m_(size_m), turn_rad_(turn_rad), cosine_(std::cos(turn_rad)), sine_(std::sin(turn_rad)) {}
  [[nodiscard]] double turn_rad() const { return turn_rad_; }
  /// Reaches every corner of the site.
  [[nodiscard]] double reach_m() const { return 0.5 * size_m_ * (std::abs(cosine_) + std::abs(sine_)); }
  [[nodiscard]] Vec2 at(double u, double v) const {
    return Vec2{0.5 * size_m_, 0.5 * size_m_} + Vec2{cosine_ * u - sine_ * v, sine_ * u + cosine_ * v};
  }
  /// Of the line (u, v) for fixed v, or v, u where `across`: where it lies in the site and `beyond_m` outside.
  struct Span {
    double begin = 0.0, end = 0.0;
  };
  [[nodiscard]] std::optional<Span> span(double fixed, bool across, double beyond_m) const {
    const Box2 box = Box2{0.0, 0.0, size_m_, size_m_}.grown(beyond_m);
    std::optional<Span> found;
    const double reach = reach_m() + 2.0 * beyond_m;
    for (double x = -reach; x <= reach; x += 2.0) {
      if (!box.contains(across ? at(fixed, x) : at(x, fixed))) continue;
      if (!found) found = Span{x, x};
      found->end = x;
    }
    return found;
  }
  /// The line enters and leaves the site once at most, and some of it lies inside.
  [[nodiscard]] bool passes_once(const Alignment& line, double least_inside_m) const {
    const Box2 box{0.0, 0.0, size_m_, size_m_};
    int changes = 0, inside = 0;
    bool was_in = false;
    const Polyline points = sample(line, 2.0);
    for (const Vec2 p : points) {
      const bool in = box.contains(p);
      changes += in && !was_in ? 1 : 0, inside += in ? 1 : 0;
      was_in = in;
    }
    return changes == 1 && 2.0 * inside > least_inside_m;
  }

 private:
  double size_m_, turn_rad_, cosine_, sine_;
};

/// Where side roads join: exactly on a road's curve, and not too near each other.
class Joints {
 public:
  explicit Joints(const Planner& planner, double least_gap_m) : planner_(planner), least_gap_m_(least_gap_m) {}
  struct Joint {
    std::size_t road = 0;
    double s_m = 0.0;
    AlignmentPoint q;
  };
  /// The place on the road nearest to p; an old joint where one is near. None where another would be too near, or
  /// at the road's ends.
  [[nodiscard]] std::optional<Joint> find(std::size_t road, Vec2 p, bool may_share) const {
    const Alignment& line = planner_.plan_.roads[road].alignment;
    double s = nearest_s(line, p);
    if (s < least_gap_m_ || s > line.length_m - least_gap_m_) return std::nullopt;
    for (const Joint& old : taken_) {
      if (old.road != road || std::abs(old.s_m - s) >= least_gap_m_) continue;
      if (!may_share) return std::nullopt;
      return old;
    }
    return Joint{road, s, evaluate(line, s)};
  }
  void take(const Joint& joint) { taken_.push_back(joint); }

 private:
  const Planner& planner_;
  double least_gap_m_;
  std::vector<Joint> taken_;
};

/// A road that leaves another one at this angle or more is a side road.
[[nodiscard]] inline bool leaves_aside(const AlignmentPoint& main, Vec2 toward) {
  const Vec2 along{std::cos(main.heading_rad), std::sin(main.heading_rad)};
  return std::abs(cross(along, normalized(toward - main.p))) > 0.7;
}

/// Finds the junctions, all at grade, and leaves out roads that do not hang together with most of the others.
inline void join_roads(SitePlan& plan) {
  const BridgeRule at_grade = [](std::size_t, std::size_t) { return std::optional<std::size_t>(); };
  find_junctions(plan, at_grade);
  std::vector<std::size_t> group(plan.roads.size());
  for (std::size_t r = 0; r < group.size(); ++r) group[r] = r;
  for (const PlannedJunction& junction : plan.junctions)
    for (const PlannedJunction::Arm& arm : junction.arms)
      std::replace(group.begin(), group.end(), std::size_t{group[arm.road]}, std::size_t{group[junction.arms[0].road]});
  std::vector<double> length_m(group.size(), 0.0);
  for (std::size_t r = 0; r < group.size(); ++r) length_m[group[r]] += plan.roads[r].alignment.length_m;
  const auto largest = static_cast<std::size_t>(std::max_element(length_m.begin(), length_m.end()) - length_m.begin());
  std::vector<PlannedRoad> kept;
  for (std::size_t r = 0; r < group.size(); ++r)
    if (group[r] == largest) kept.push_back(std::move(plan.roads[r]));
  const bool all = kept.size() == plan.roads.size();
  plan.roads = std::move(kept);
  if (all) return;
  plan.junctions.clear();
  find_junctions(plan, at_grade);
}

}  // namespace orthodrive::synth
