// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/plan_country.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "orthodrive/synth/plan/countryside.hpp"
#include "orthodrive/synth/plan/planner.hpp"

namespace orthodrive::synth {
namespace {
constexpr double half_turn_rad = std::numbers::pi;
constexpr double country_overhang_m = 150.0;  // roads that leave the site go on by this
constexpr double inner_off_m = 150.0;         // of the road round the track, from its hull
constexpr double kept_free_m = 70.0;          // round the hull: no woods, no lakes
constexpr double least_between_m = 500.0;     // from the inner to the outer road round the track
constexpr int ring_corners = 16, spokes = 6;

Vec2 direction_of(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Drawn in polar coordinates about the middle of the track's hull. Ends of roads lie exactly on the curves that they
/// meet.
class CountryPlanner {
 public:
  CountryPlanner(SitePlan& plan, std::uint64_t seed)
      : plan_(plan), random_(derive_seed(seed, 24)), hull_(convex_hull(sample(plan.roads[0].alignment, 10.0))) {
    const Box2 box = bounds_of(hull_);
    middle_ = {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
    for (int i = 0; i < ring_corners; ++i)
      reach_m_ = std::max(reach_m_, extent_m(2.0 * half_turn_rad * i / ring_corners));
  }

  void add() {
    inner_ = add_ring("unclassified", "Ringstrasse", [&](double angle) { return extent_m(angle) + inner_off_m; });
    const double most_m = 0.5 * plan_.size_m - 200.0, outer_m = std::min(most_m, reach_m_ + inner_off_m + 800.0);
    if (outer_m > reach_m_ + inner_off_m + least_between_m)
      outer_ = add_ring("tertiary", "Umfahrung", [&](double angle) {
        return 0.5 * (outer_m + std::min(outer_m, extent_m(angle) + inner_off_m + 800.0)) +
               random_.uniform(-30.0, 30.0);
      });
    const double turn = random_.uniform(0.0, 2.0 * half_turn_rad / spokes);
    for (int k = 0; k < spokes; ++k)
      add_spoke(k, turn + 2.0 * half_turn_rad * k / spokes + random_.uniform(-0.12, 0.12));
    for (std::size_t k = 0; k < spokes_.size(); k += 2) add_village(spokes_[k]);
    for (std::size_t k = 0; k < spokes_.size(); ++k) add_lane(spokes_[k], spokes_[(k + 1) % spokes_.size()]);
    for (std::size_t k = 0; k < spokes_.size(); ++k) add_car_park(spokes_[k].angle + half_turn_rad / spokes);
    add_farms();
    add_lakes_and_woods(plan_, static_cast<int>(plan_.size_m * plan_.size_m / 2e6), {grown_hull()}, random_);
  }

 private:
  struct Spoke {
    std::size_t road = 0;
    double angle = 0.0;
    double length_m = 0.0;  ///< inside the site
  };

  /// From the middle to the tangent of the hull across a direction: a place so far away lies outside.
  [[nodiscard]] double extent_m(double angle) const {
    double most = 0.0;
    for (const Vec2 p : hull_) most = std::max(most, dot(p - middle_, direction_of(angle)));
    return most;
  }
  [[nodiscard]] Polygon grown_hull() const {
    Ring ring;
    for (int i = 0; i < 2 * ring_corners; ++i) {
      const double angle = half_turn_rad * i / ring_corners;
      ring.push_back(middle_ + direction_of(angle) * (extent_m(angle) + kept_free_m));
    }
    return {ring, {}};
  }

  std::size_t add(PlannedRoad road) {
    const int lanes = road.oneway ? 1 : 2;
    road.width_m = default_width_m(road.highway, lanes, Oneway::no) * random_.uniform(0.92, 1.15);
    plan_.roads.push_back(std::move(road));
    return plan_.roads.size() - 1;
  }
  std::size_t add(const std::string& highway, const std::string& name, const std::vector<Corner>& corners) {
    return add({.highway = highway, .name = name, .alignment = round_corners(corners, false)});
  }
  template <typename Radius>
  std::size_t add_ring(const std::string& highway, const std::string& name, const Radius& radius_m) {
    std::vector<Corner> corners;
    for (int i = 0; i < ring_corners; ++i) {
      const double angle = 2.0 * half_turn_rad * i / ring_corners;
      corners.push_back({middle_ + direction_of(angle) * radius_m(angle), 250.0});
    }
    return add({.highway = highway, .name = name, .alignment = round_corners(corners, true)});
  }
  [[nodiscard]] Vec2 on(std::size_t road, Vec2 p) const {
    const Alignment& a = plan_.roads[road].alignment;
    return evaluate(a, nearest_s(a, p)).p;
  }

  /// From the inner ring over the site's border. Straight in its first part, where a village may lie.
  void add_spoke(int k, double angle) {
    const Vec2 out = direction_of(angle), across = left_normal(out);
    const Vec2 begin = on(inner_, middle_ + out * (extent_m(angle) + inner_off_m));
    double inside_m = 0.0;
    const Box2 site{0.0, 0.0, plan_.size_m, plan_.size_m};
    while (site.contains(begin + out * inside_m)) inside_m += 10.0;
    std::vector<Corner> corners{{begin, 0.0}};
    const double straight_m = std::min(620.0, 0.6 * inside_m);
    double bend_m = 0.0;
    for (double at = straight_m; at < inside_m + country_overhang_m - 150.0; at += 330.0) {
      corners.push_back({begin + out * at + across * bend_m, 300.0});
      bend_m += random_.uniform(-60.0, 60.0);
    }
    corners.push_back({begin + out * (inside_m + country_overhang_m) + across * bend_m, 0.0});
    const std::size_t road =
        add(k % 3 == 0 ? "secondary" : "tertiary", fmt::format("Landesstrasse {}", k + 1), corners);
    spokes_.push_back({road, angle, inside_m});
  }

  /// Streets on both sides of a spoke, which is its main road.
  void add_village(const Spoke& spoke) {
    const double half_m = random_.uniform(190.0, 230.0), middle_m = 130.0 + half_m;
    if (middle_m + half_m + 60.0 > spoke.length_m) return;
    const Vec2 out = direction_of(spoke.angle), across = left_normal(out);
    const Vec2 begin = evaluate(plan_.roads[spoke.road].alignment, 0.0).p;
    const auto at = [&](double along_m, double across_m) { return begin + out * along_m + across * across_m; };
    const double low = middle_m - half_m, high = middle_m + half_m;
    std::array<std::size_t, 2> sides{};
    for (const int side : {0, 1}) {
      const double off_m = (side == 0 ? -1.0 : 1.0) * random_.uniform(120.0, 170.0);
      sides[static_cast<std::size_t>(side)] = add(
          "residential", fmt::format("Gasse {}", ++streets_),
          {{at(low, off_m), 0.0}, {at(middle_m, off_m + random_.uniform(-15.0, 15.0)), 200.0}, {at(high, off_m), 0.0}});
    }
    const int count = 4;
    for (int i = 0; i < count; ++i) {
      const double along_m = low + (high - low) * i / (count - 1), jitter_m = i == 0 || i + 1 == count ? 0.0 : 12.0;
      const double a = along_m + random_.uniform(-jitter_m, jitter_m),
                   b = along_m + random_.uniform(-jitter_m, jitter_m);
      add("residential", fmt::format("Gasse {}", ++streets_),
          {{on(sides[0], at(a, -145.0)), 0.0}, {on(sides[1], at(b, 145.0)), 0.0}});
    }
    constexpr double lots_m = 40.0;
    const Ring outline{at(low - lots_m, -210.0), at(high + lots_m, -210.0), at(high + lots_m, 210.0),
                       at(low - lots_m, 210.0)};
    add_area(plan_, outline, Cover::meadow, false);
    plan_.settlements.push_back({{outline, {}}, false});
  }

  /// From one spoke to the next, between the outer ring and the site's border.
  void add_lane(const Spoke& from, const Spoke& to) {
    // Lanes on both sides of a spoke meet it 30 m apart and more: nearer ones would be one junction.
    const auto place = [&](const Spoke& spoke, double side) {
      const double at_m = std::min(spoke.length_m - 120.0, 0.82 * spoke.length_m) + side * random_.uniform(15.0, 40.0);
      return evaluate(plan_.roads[spoke.road].alignment, at_m).p;
    };
    const Vec2 a = place(from, 1.0), b = place(to, -1.0), bulge = normalized(a + b - middle_ * 2.0);
    const double bow_m = 0.16 * distance(a, b);
    lanes_.push_back(add(
        "unclassified", fmt::format("Feldweg {}", lanes_.size() + 1),
        {{a, 0.0}, {a + (b - a) * 0.3 + bulge * bow_m, 250.0}, {a + (b - a) * 0.7 + bulge * bow_m, 250.0}, {b, 0.0}}));
  }

  /// Beside the inner ring, between the spokes.
  void add_car_park(double angle) {
    const Alignment& ring = plan_.roads[inner_].alignment;
    const AlignmentPoint q =
        evaluate(ring, nearest_s(ring, middle_ + direction_of(angle) * (extent_m(angle) + inner_off_m)));
    const Vec2 along = direction_of(q.heading_rad);
    if (std::abs(q.curvature_1pm) > 1.0 / 400.0) return;
    const Vec2 outward = left_normal(along) * (dot(left_normal(along), q.p - middle_) > 0.0 ? 1.0 : -1.0);
    const double half_m = random_.uniform(35.0, 60.0), gap_m = 0.5 * plan_.roads[inner_].width_m + 1.0;
    for (const int row : {0, 1}) {
      const Vec2 corner = q.p + outward * (gap_m + 17.0 * row) - along * half_m;
      add_area(plan_,
               {corner, corner + along * (2.0 * half_m), corner + along * (2.0 * half_m) + outward * 17.0,
                corner + outward * 17.0},
               Cover::parking, true);
    }
  }

  void add_farms() {
    const Box2 site{0.0, 0.0, plan_.size_m, plan_.size_m};
    std::vector<std::size_t> along = lanes_;
    if (outer_) along.push_back(*outer_);
    for (const std::size_t road : along) {
      const Alignment alignment = plan_.roads[road].alignment;
      const int count = std::max(2, static_cast<int>(alignment.length_m / 450.0));
      for (int i = 0; i < count; ++i) {
        const AlignmentPoint q =
            evaluate(alignment, (i + 0.5 + random_.uniform(-0.15, 0.15)) / count * alignment.length_m);
        const Vec2 outward = left_normal(direction_of(q.heading_rad)) * (random_.below(2) ? 1.0 : -1.0);
        const double length_m = random_.uniform(60.0, 110.0);
        const Vec2 yard = q.p + outward * length_m;
        const bool free = site.grown(-60.0).contains(yard) && is_free(yard, road) &&
                          std::none_of(plan_.settlements.begin(), plan_.settlements.end(),
                                       [&](const Settlement& s) { return contains(s.outline, yard); });
        if (!free) continue;
        add("service", "", {{q.p, 0.0}, {yard, 0.0}});
        add_farm(plan_, yard, outward, random_);
      }
    }
  }
  /// No other road near.
  [[nodiscard]] bool is_free(Vec2 p, std::size_t own) const {
    for (std::size_t r = 0; r < plan_.roads.size(); ++r) {
      const double least_m = r == own ? 45.0 : 70.0;
      if (distance(on(r, p), p) < least_m) return false;
    }
    return true;
  }

  SitePlan& plan_;
  Random random_;
  Ring hull_;
  Vec2 middle_;
  double reach_m_ = 0.0;  ///< of the hull, from its middle
  std::size_t inner_ = 0;
  std::optional<std::size_t> outer_;
  std::vector<Spoke> spokes_;
  std::vector<std::size_t> lanes_;
  int streets_ = 0;
};

}  // namespace

void add_country(SitePlan& plan, std::uint64_t seed) {
  CountryPlanner(plan, seed).add();
  plan.surroundings = Surroundings::region, plan.relief = 1.6;
  for (std::size_t i = 0; i < plan.areas.size(); ++i) plan.areas[i].id = static_cast<std::int32_t>(i);
  for (std::size_t i = 0; i < plan.buildings.size(); ++i) plan.buildings[i].id = static_cast<std::int32_t>(i);
  find_junctions(plan, [](std::size_t, std::size_t) { return std::nullopt; });
}

}  // namespace orthodrive::synth
