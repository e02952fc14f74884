// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/synth/plan/countryside.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/plan/street_frame.hpp"

namespace orthodrive::synth {
namespace {
constexpr double beyond_m = 40.0;  // streets that leave the site go on by this

/// A street of the grid; `fixed` is its v, or its u where it runs across.
struct GridStreet {
  double fixed = 0.0;
  std::size_t road = 0;
  bool avenue = false;
};

/// Two families of nearly straight streets that cross, alleys through the blocks, shops with car parks on the avenue.
class GridPlanner {
 public:
  GridPlanner(double size_m, std::uint64_t seed)
      : planner_(size_m, seed),
        random_(planner_.random_),
        size_m_(size_m),
        frame_(size_m, random_.uniform() < 0.4 ? 0.0 : random_.uniform(-0.6, 0.6)),
        joints_(planner_, 14.0),
        bend_m_(random_.uniform() < 0.6 ? 0.0 : random_.uniform(3.0, 9.0)),
        depth_m_(random_.uniform(84.0, 104.0)),
        width_m_(random_.uniform(130.0, 190.0)),
        alley_share_(random_.uniform() < 0.65 ? 0.85 : 0.0) {}

  SitePlan plan() {
    lay_streets(rows_, depth_m_, false);
    lay_streets(columns_, width_m_, true);
    lay_ground();
    for (std::size_t i = 0; i + 1 < columns_.size(); ++i)
      for (std::size_t j = 0; j + 1 < rows_.size(); ++j) lay_block(i, j);
    settle();
    SitePlan plan = std::move(planner_.plan_);
    plan.name = "Grid", plan.surroundings = Surroundings::settled, plan.relief = 0.3;
    join_roads(plan);
    return plan;
  }

 private:
  void lay_streets(std::vector<GridStreet>& streets, double gap_m, bool across) {
    const double reach = frame_.reach_m();
    const double first = -reach + random_.uniform(0.2, 0.8) * gap_m;
    const auto avenue = static_cast<std::size_t>(reach / gap_m);
    for (double fixed = first; fixed < reach; fixed += gap_m * random_.uniform(0.94, 1.06)) {
      const bool is_avenue = streets.size() == avenue;
      const auto span = frame_.span(fixed, across, beyond_m);
      if (!span || span->end - span->begin < 120.0) continue;
      std::vector<Corner> corners;
      const int pieces = bend_m_ > 0.0 ? std::max(2, static_cast<int>((span->end - span->begin) / 150.0)) : 1;
      for (int i = 0; i <= pieces; ++i) {
        const double x = span->begin + (span->end - span->begin) * i / pieces,
                     off = fixed + random_.uniform(-bend_m_, bend_m_);
        corners.push_back({across ? frame_.at(off, x) : frame_.at(x, off), random_.uniform(80.0, 200.0)});
      }
      PlannedRoad road{.highway = is_avenue ? (across ? "tertiary" : "secondary") : "residential",
                       .name = fmt::format("{} {}", across ? "Avenue" : "Street", streets.size() + 1),
                       .width_m = is_avenue ? (across ? random_.uniform(11.0, 13.0) : random_.uniform(13.0, 16.0))
                                            : random_.uniform(9.0, 12.5),
                       .lanes = is_avenue && !across ? 4 : 2,
                       .alignment = round_corners(corners, false)};
      if (!frame_.passes_once(road.alignment, 100.0)) continue;
      if (across && std::any_of(rows_.begin(), rows_.end(), [&](const GridStreet& row) {
            const Alignment& line = planner_.plan_.roads[row.road].alignment;
            return ends_at(road.alignment, line) || ends_at(line, road.alignment);
          }))
        continue;
      streets.push_back({fixed, planner_.add(std::move(road)), is_avenue});
    }
  }

  /// `a` stops so near `b`, outside the site, that their carriageways may touch without a junction.
  [[nodiscard]] static bool ends_at(const Alignment& a, const Alignment& b) {
    const Polyline line = sample(b, 4.0);
    return project_onto(line, evaluate(a, 0.0).p).distance_m < 22.0 ||
           project_onto(line, evaluate(a, a.length_m).p).distance_m < 22.0;
  }

  /// Town everywhere, or up to a line beyond which there are fields.
  void lay_ground() {
    const double reach = frame_.reach_m() + 100.0;
    const double limit = random_.uniform() < 0.6 ? reach : random_.uniform(0.2, 0.6) * reach;
    town_ = {frame_.at(-reach, -reach), frame_.at(limit, -reach), frame_.at(limit, reach), frame_.at(-reach, reach)};
    add_area(planner_.plan_, town_, Cover::meadow, false);
    planner_.plan_.settlements.push_back({{town_, {}}, true});
  }

  void lay_block(std::size_t i, std::size_t j) {
    const double u0 = columns_[i].fixed, u1 = columns_[i + 1].fixed, v0 = rows_[j].fixed, v1 = rows_[j + 1].fixed;
    const Vec2 middle = frame_.at(0.5 * (u0 + u1), 0.5 * (v0 + v1));
    const bool in_site = Box2{0.0, 0.0, size_m_, size_m_}.grown(-30.0).contains(middle);
    const bool beside_avenue = rows_[j].avenue || rows_[j + 1].avenue;
    const double draw = random_.uniform();
    if (in_site && contains(Polygon{town_, {}}, middle) && draw < (beside_avenue ? 0.65 : 0.06)) {
      lay_shops({u0, u1}, {v0, v1}, rows_[j].avenue);
    } else if (random_.uniform() < alley_share_ && contains(Polygon{town_, {}}, middle)) {
      const Vec2 from = frame_.at(u0, 0.5 * (v0 + v1)), to = frame_.at(u1, 0.5 * (v0 + v1));
      const auto a = joints_.find(columns_[i].road, from, true), b = joints_.find(columns_[i + 1].road, to, true);
      if (!a || !b || distance(a->q.p, from) > 12.0 || distance(b->q.p, to) > 12.0) return;
      PlannedRoad alley{.highway = "service",
                        .width_m = random_.uniform(3.2, 5.0),
                        .lanes = 1,
                        .alignment = round_corners({{a->q.p, 0.0}, {b->q.p, 0.0}}, false)};
      if (!frame_.passes_once(alley.alignment, 30.0)) return;
      joints_.take(*a), joints_.take(*b);
      planner_.add(std::move(alley));
    }
  }

  /// A large flat roof and rows of parking before it.
  void lay_shops(StreetFrame::Span u, StreetFrame::Span v, bool avenue_below) {
    const double inset = 0.5 * 16.0 + bend_m_ + 4.0;
    u = {u.begin + inset, u.end - inset}, v = {v.begin + inset, v.end - inset};
    if (u.end - u.begin < 50.0 || v.end - v.begin < 50.0) return;
    const auto box = [&](double u0, double u1, double v0, double v1) {
      return Ring{frame_.at(u0, v0), frame_.at(u1, v0), frame_.at(u1, v1), frame_.at(u0, v1)};
    };
    add_area(planner_.plan_, box(u.begin, u.end, v.begin, v.end), Cover::paved, false);
    const double bays_m = random_.uniform(16.0, 18.5);
    const int strips = random_.uniform() < 0.5 ? 1 : 2;
    for (int k = 0; k < strips; ++k) {
      const double v0 = avenue_below ? v.begin + 1.0 + k * bays_m : v.end - 1.0 - (k + 1) * bays_m;
      planner_.plan_.parkings.push_back({box(u.begin + 2.0, u.end - 2.0, v0, v0 + bays_m), {}});
    }
    const double room = v.end - v.begin - strips * bays_m - 6.0;
    const double half_v = 0.5 * std::min(room, random_.uniform(22.0, 45.0));
    const double middle_v = avenue_below ? v.end - 3.0 - half_v : v.begin + 3.0 + half_v;
    double at = u.begin + 3.0;
    while (at < u.end - 18.0) {
      const double length = std::min(u.end - 3.0 - at, random_.uniform(18.0, 70.0));
      const auto tone = static_cast<float>(random_.uniform(0.45, 0.85));
      House shop{frame_.at(at + 0.5 * length, middle_v),
                 frame_.turn_rad(),
                 0.5 * length,
                 half_v,
                 random_.uniform(5.0, 11.0),
                 0.0,
                 RoofShape::flat,
                 {tone, tone, tone * 0.98f}};
      if (half_v > 5.0 && length > 10.0) planner_.plan_.buildings.push_back(shop);
      at += length + random_.uniform(2.0, 12.0);
    }
  }

  void settle() {
    SitePlan& plan = planner_.plan_;
    plan.walk_from_m = random_.uniform(1.0, 2.4), plan.walk_to_m = plan.walk_from_m + random_.uniform(1.2, 1.7);
    Settling& s = plan.settling;
    s.lots = {.least_length_m = 15.0,
              .most_length_m = 24.0,
              .walk_m = plan.walk_to_m,
              .least_setback_m = 4.5,
              .most_setback_m = 8.5,
              .least_depth_m = 0.5 * depth_m_ - 12.0,
              .most_depth_m = 0.5 * depth_m_ - 9.0,
              .least_half_front_m = 4.2,
              .most_half_front_m = 8.5,
              .side_gap_m = 2.2,
              .least_half_deep_m = 5.0,
              .most_half_deep_m = 7.5,
              .least_eave_m = 3.0,
              .most_eave_m = 6.0,
              .road_gap_m = 3.0,
              .house_gap_m = 1.8};
    s.built_share = random_.uniform(0.75, 0.95);
    s.lawn_share = 0.95;
    s.tree_clearance_m = random_.uniform(0.8, 2.0);
    s.roadside_trees = random_.uniform(0.1, 0.8);
    s.scattered_per_ha = random_.uniform(1.0, 9.0);
    s.parked_share = random_.uniform(0.08, 0.3);
  }

  Planner planner_;
  Random& random_;
  double size_m_;
  StreetFrame frame_;
  Joints joints_;
  double bend_m_, depth_m_, width_m_, alley_share_;
  std::vector<GridStreet> rows_, columns_;
  Ring town_;
};
}  // namespace

SitePlan plan_grid(double size_m, std::uint64_t seed) {
  check_preset_size(size_m, 300.0, 2000.0);
  return GridPlanner(size_m, seed).plan();
}

}  // namespace orthodrive::synth
