// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/countryside.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/synth/plan/planner.hpp"

namespace orthodrive::synth {

void add_area(SitePlan& plan, Ring ring, Cover cover, bool mapped) {
  const auto id = static_cast<std::int32_t>(plan.areas.size());
  plan.areas.push_back({{std::move(ring), {}}, cover, mapped, id});
}

void add_farm(SitePlan& plan, Vec2 yard, Vec2 outward, Random& random) {
  const double heading = std::atan2(outward.y, outward.x);
  const Vec2 across = left_normal(outward);
  constexpr Rgb red{0.58f, 0.33f, 0.26f}, grey{0.42f, 0.40f, 0.38f};
  for (const double side : {-1.0, 1.0}) {
    House house{yard + outward * 9.0 + across * (side * 16.0),
                heading,
                random.uniform(9.0, 14.0),
                random.uniform(5.0, 7.5),
                random.uniform(4.0, 6.0),
                0.6,
                RoofShape::gable,
                side < 0.0 ? red : grey};
    house.id = static_cast<std::int32_t>(plan.buildings.size());
    plan.buildings.push_back(house);
  }
}

void add_lakes_and_woods(SitePlan& plan, int count, const MultiPolygon& kept_free, Random& random) {
  std::vector<Polyline> lines;
  lines.reserve(plan.roads.size());
  for (const PlannedRoad& road : plan.roads) lines.push_back(sample(road.alignment, 20.0));
  const SegmentIndex index(lines);
  std::vector<std::pair<Vec2, double>> lakes;
  const auto room_m = [&](Vec2 p, double most_m) {
    double room = most_m;
    for (const SegmentIndex::Segment& s : index.near(p, most_m))
      room = std::min(room, project_onto(std::span(lines[s.line]).subspan(s.index, 2), p).distance_m);
    for (const auto& [center, radius] : lakes) room = std::min(room, distance(center, p) - radius);
    return room;
  };
  const auto anywhere = [&] { return Vec2{random.uniform(0.0, plan.size_m), random.uniform(0.0, plan.size_m)}; };
  for (int k = 0; k < count; ++k)  // lakes keep off roads and farms
    for (int attempt = 0; attempt < 12; ++attempt) {
      const Vec2 p = anywhere();
      const double radius_m = (room_m(p, 230.0) - 30.0) / 1.75;
      if (radius_m < 40.0 || contains(kept_free, p)) continue;
      add_area(plan, blob(random, p, 1.25 * radius_m), Cover::meadow, false);
      add_area(plan, blob(random, p, radius_m), Cover::water, true);
      lakes.emplace_back(p, 1.75 * radius_m);
      break;
    }
  for (int k = 0; k < 4 * count; ++k) {  // woods keep off settlements and lakes
    const Vec2 p = anywhere();
    const double radius_m = random.uniform(70.0, 240.0);
    const Ring ring = blob(random, p, radius_m);
    const auto lies_in = [&](const auto& outline) {
      return contains(outline, p) ||
             std::any_of(ring.begin(), ring.end(), [&](Vec2 q) { return contains(outline, q); });
    };
    const bool free =
        std::none_of(lakes.begin(), lakes.end(),
                     [&](const auto& lake) { return distance(lake.first, p) < lake.second + 1.4 * radius_m; }) &&
        std::none_of(plan.settlements.begin(), plan.settlements.end(),
                     [&](const Settlement& s) { return lies_in(s.outline); }) &&
        !lies_in(kept_free);
    if (free) add_area(plan, ring, Cover::forest_floor, true);
  }
}

}  // namespace orthodrive::synth
