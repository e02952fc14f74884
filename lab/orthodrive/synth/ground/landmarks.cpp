// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/ground/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/synth/plan/planner.hpp"
#include "orthodrive/synth/plan/trackside.hpp"

namespace orthodrive::synth {
namespace {
constexpr Rgb roof_red{0.52f, 0.30f, 0.24f}, roof_dark{0.33f, 0.31f, 0.31f}, roof_pale{0.68f, 0.68f, 0.67f},
    roof_rust{0.47f, 0.35f, 0.28f};

/// A place of its own, with its own axes.
struct Ground {
  Vec2 middle;
  double turn_rad = 0.0;
  [[nodiscard]] Vec2 at(double u, double v) const {
    return middle + Vec2{std::cos(turn_rad), std::sin(turn_rad)} * u +
           Vec2{-std::sin(turn_rad), std::cos(turn_rad)} * v;
  }
};

class Landmarks {
 public:
  Landmarks(SitePlan& plan, std::uint64_t seed) : plan_(plan), random_(derive_seed(seed, 21)) {
    for (const PlannedRoad& road : plan.roads) lines_.emplace_back(sample(road.alignment, 8.0), 0.5 * road.width_m);
  }

  void add_all() {
    add_railway();
    add_river();
    const int each = std::max(1, static_cast<int>(std::lround(2e-6 * plan_.size_m * plan_.size_m)));
    for (int i = 0; i < each; ++i) {
      add_at(26.0, &Landmarks::add_quarry);
      add_at(30.0, &Landmarks::add_works);
      add_at(28.0, &Landmarks::add_towers);
      add_at(28.0, &Landmarks::add_town_houses);
      add_at(27.0, &Landmarks::add_farm);
      for (int k = 0; k < 3; ++k) add_at(24.0, &Landmarks::add_orchard);
      add_at(19.0, &Landmarks::add_snow);
    }
  }

 private:
  /// In a free disc of that radius; away from roads, or at least beside them, where there are no lots in the way.
  void add_at(double radius_m, void (Landmarks::*add)(const Ground&)) {
    for (const double from_roads_m : {45.0, 20.0, 8.0})
      for (int attempt = 0; attempt < 200; ++attempt) {
        const double edge_m = 24.0 + radius_m;
        const Vec2 p{random_.uniform(edge_m, plan_.size_m - edge_m), random_.uniform(edge_m, plan_.size_m - edge_m)};
        if (!is_free(p, radius_m, from_roads_m)) continue;
        taken_.emplace_back(p, radius_m);
        (this->*add)({p, random_.uniform(0.0, 2.0 * std::numbers::pi)});
        return;
      }
  }

  [[nodiscard]] bool is_free(Vec2 p, double radius_m, double from_roads_m) const {
    const auto far = [&](const auto& line) {
      return project_onto(line.first, p).distance_m > radius_m + line.second + from_roads_m;
    };
    const auto apart = [&](const auto& disc) { return distance(disc.first, p) > radius_m + disc.second + 4.0; };
    const auto outside = [&](const Polygon& polygon) {
      return !contains(polygon, p) && std::all_of(polygon.outer.begin(), polygon.outer.end(),
                                                  [&](Vec2 corner) { return distance(corner, p) > radius_m + 2.0; });
    };
    return std::all_of(lines_.begin(), lines_.end(), far) && std::all_of(taken_.begin(), taken_.end(), apart) &&
           std::all_of(plan_.areas.begin(), plan_.areas.end(),
                       [&](const Area& area) { return area.cover == Cover::meadow || outside(area.polygon); }) &&
           std::all_of(plan_.parkings.begin(), plan_.parkings.end(), outside) &&
           std::all_of(plan_.buildings.begin(), plan_.buildings.end(), [&](const House& house) {
             return distance(house.center, p) > radius_m + std::hypot(house.half_length_m, house.half_width_m);
           });
  }

  void area(Ring ring, Cover cover) { plan_.areas.push_back({{std::move(ring), {}}, cover, false}); }
  void building(const Ground& g, Vec2 at, Vec2 half_m, double eave_m, Use use, Rgb color, double pitch = 0.0) {
    plan_.buildings.push_back({g.at(at.x, at.y), g.turn_rad, half_m.x, half_m.y, eave_m, pitch,
                               pitch > 0.0 ? RoofShape::gable : RoofShape::flat, color, 0, use});
  }

  void add_railway() {
    const double x = plan_.size_m - 8.0, reach = plan_.size_m + 40.0;
    area({{x + 4.5, -40.0}, {x + 4.5, reach}, {x - 4.5, reach}, {x - 4.5, -40.0}}, Cover::rails);
  }
  void add_river() {
    Ring ring, back;
    const double phase = random_.uniform(0.0, 6.0), half_m = random_.uniform(4.0, 6.0);
    for (double x = -40.0; x <= plan_.size_m - 14.0; x += 4.0) {
      const double y = plan_.size_m - 12.0 + 5.0 * std::sin(x / 55.0 + phase);
      ring.push_back({x, y - half_m * (1.0 + 0.2 * std::sin(x / 23.0))});
      back.push_back({x, y + half_m});
    }
    ring.insert(ring.end(), back.rbegin(), back.rend());
    area(std::move(ring), Cover::river);
  }
  void add_quarry(const Ground& g) {
    area(blob(random_, g.middle, 18.0), Cover::dirt);
    area(blob(random_, g.at(-2.0, 1.0), 13.5), Cover::rock);
    area(blob(random_, g.at(8.0, -4.0), 6.5), Cover::debris);
  }
  void add_works(const Ground& g) {
    area(rectangle(g.middle, g.turn_rad, 26.0, 15.0), Cover::paved);
    building(g, {-6.0, 2.0}, {17.0, 10.0}, 9.0, Use::works, random_.uniform() < 0.5 ? roof_pale : roof_dark);
    area(blob(random_, g.at(19.0, -6.0), 4.5), Cover::debris);
  }
  void add_towers(const Ground& g) {
    area(blob(random_, g.middle, 20.0), Cover::lawn);
    for (const double side : {-1.0, 1.0})
      building(g, {13.0 * side, 2.0 * side}, {8.5, 7.5}, 24.0, Use::tower,
               random_.uniform() < 0.5 ? roof_pale : roof_dark);
  }
  void add_town_houses(const Ground& g) {
    area(rectangle(g.middle, g.turn_rad, 24.0, 13.0), Cover::paved);
    for (const double side : {-1.0, 1.0})
      building(g, {0.0, 9.5 * side}, {21.0, 5.5}, 11.0, Use::town_house, random_.uniform() < 0.6 ? roof_red : roof_dark,
               0.6);
  }
  void add_farm(const Ground& g) {
    area(rectangle(g.middle, g.turn_rad, 22.0, 13.0), Cover::dirt);
    building(g, {-6.0, 7.0}, {15.0, 6.5}, 5.5, Use::farm, roof_rust, 0.35);
    building(g, {-2.0, -8.5}, {11.0, 5.0}, 4.5, Use::farm, roof_pale, 0.3);
    for (const double x : {14.0, 19.0}) building(g, {x, 6.0}, {1.9, 1.9}, 12.0, Use::farm, roof_pale);
  }
  void add_orchard(const Ground& g) {
    const Polygon ground{rectangle(g.middle, g.turn_rad, 20.0, 12.0), {}};
    plan_.areas.push_back({ground, Cover::orchard, false});
    plan_.settling.orchards.push_back({ground, g.turn_rad, 5.0, 4.0, 1.6});
  }
  void add_snow(const Ground& g) { area(blob(random_, g.middle, 13.0), Cover::snow); }

  SitePlan& plan_;
  Random random_;
  std::vector<std::pair<Polyline, double>> lines_;  ///< of the roads, with half their widths
  std::vector<std::pair<Vec2, double>> taken_;      ///< discs
};
}  // namespace

void add_landmarks(SitePlan& plan, std::uint64_t seed) {
  if (plan.circuit && is_raceway(plan.roads[*plan.circuit].highway)) add_barriers(plan, *plan.circuit);
  Landmarks(plan, seed).add_all();
}

}  // namespace orthodrive::synth
