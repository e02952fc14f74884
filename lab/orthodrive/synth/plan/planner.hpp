// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the plans of the presets are built with.

#include <cmath>
#include <numbers>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// A wobbly disc, at most 1.4 times as far as its radius.
[[nodiscard]] inline Ring blob(Random& random, Vec2 center, double radius_m) {
  constexpr double turn = 2.0 * std::numbers::pi;
  const double p1 = random.uniform(0.0, turn), p2 = random.uniform(0.0, turn), p3 = random.uniform(0.0, turn);
  Ring ring;
  for (int i = 0; i < 40; ++i) {
    const double a = turn * i / 40;
    ring.push_back(center + Vec2{std::cos(a), std::sin(a)} *
                                (radius_m * (1.0 + 0.22 * std::cos(2 * a + p1) + 0.12 * std::cos(3 * a + p2) +
                                             0.06 * std::cos(7 * a + p3))));
  }
  return ring;
}

/// Builds the plan in the unit square, turned and mirrored by seed.
class Planner {
 public:
  Planner(double size_m, std::uint64_t seed)
      : random_(derive_seed(seed, 1)),
        quarter_turns_(static_cast<int>(random_.below(4))),
        mirrored_(random_.below(2) == 1) {
    plan_.size_m = size_m;
  }

  [[nodiscard]] Vec2 place(double u, double v) const {
    Vec2 p{mirrored_ ? 0.5 - u : u - 0.5, v - 0.5};
    for (int i = 0; i < quarter_turns_; ++i) p = left_normal(p);
    return (p + Vec2{0.5, 0.5}) * plan_.size_m;
  }
  [[nodiscard]] Vec2 jittered(double u, double v) {
    const double du = random_.uniform(-0.012, 0.012), dv = random_.uniform(-0.012, 0.012);
    return place(u + du, v + dv);
  }
  /// A point of another road near (u, v), to start or end a branch there.
  [[nodiscard]] Vec2 branch_point(std::size_t road, double u, double v) const {
    return nearest_point(road, place(u, v));
  }
  [[nodiscard]] Vec2 nearest_point(std::size_t road, Vec2 p) const {
    const Alignment& a = plan_.roads[road].alignment;
    return evaluate(a, nearest_s(a, p)).p;
  }
  std::size_t add(PlannedRoad road) {
    plan_.roads.push_back(std::move(road));
    return plan_.roads.size() - 1;
  }
  [[nodiscard]] Corner corner(double u, double v, double min_radius_m, double max_radius_m) {
    const Vec2 p = jittered(u, v);
    return {p, random_.uniform(min_radius_m, max_radius_m)};
  }
  /// True widths differ from the defaults of untagged ways by 8 to 20 %, to either side.
  [[nodiscard]] double true_width_m(const std::string& highway, int lanes, bool oneway) {
    const double share = random_.uniform(0.08, 0.20) * (random_.below(2) == 0 ? -1.0 : 1.0);
    return default_width_m(highway, lanes, oneway ? Oneway::forward : Oneway::no) * (1.0 + share);
  }
  PlannedRoad street(const std::string& highway, const std::string& name, const std::vector<Corner>& corners) {
    return {.highway = highway,
            .name = name,
            .width_m = true_width_m(highway, 0, false),
            .alignment = round_corners(corners, false)};
  }

  SitePlan plan_;
  Random random_;

 private:
  int quarter_turns_;
  bool mirrored_;
};

}  // namespace orthodrive::synth
