// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/site_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"

namespace orthodrive::synth {
namespace {
void add_arm(SitePlan& plan, Vec2 p, PlannedJunction::Arm arm) {
  auto it = std::find_if(plan.junctions.begin(), plan.junctions.end(),
                         [&](const PlannedJunction& j) { return distance(j.p, p) < 2.0; });
  if (it == plan.junctions.end()) it = plan.junctions.insert(it, {.p = p});
  const bool known = std::any_of(it->arms.begin(), it->arms.end(), [&](const PlannedJunction::Arm& a) {
    return a.road == arm.road && std::abs(a.s_m - arm.s_m) < 5.0;
  });
  if (!known) it->arms.push_back(arm);
}

/// Decks of one road that touch each other become one.
void add_bridge(SitePlan& plan, PlannedBridge bridge) {
  for (PlannedBridge& b : plan.bridges) {
    if (b.over != bridge.over) continue;
    const double begin = std::min(b.s_over_m - b.half_length_m, bridge.s_over_m - bridge.half_length_m);
    const double end = std::max(b.s_over_m + b.half_length_m, bridge.s_over_m + bridge.half_length_m);
    constexpr double least_gap_m = 10.0;
    if (end - begin > 2.0 * (b.half_length_m + bridge.half_length_m) + least_gap_m) continue;
    b.s_over_m = 0.5 * (begin + end), b.half_length_m = 0.5 * (end - begin);
    b.under.insert(b.under.end(), bridge.under.begin(), bridge.under.end());
    return;
  }
  plan.bridges.push_back(std::move(bridge));
}
}  // namespace

void find_junctions(SitePlan& plan, const BridgeRule& rule) {
  const auto& roads = plan.roads;
  std::vector<Polyline> lines;
  std::vector<Box2> boxes;
  lines.reserve(roads.size());
  for (const PlannedRoad& road : roads) {
    lines.push_back(sample(road.alignment, search_step_m));
    boxes.push_back(bounds_of(lines.back()).grown(search_step_m));
  }
  for (std::size_t b = 0; b < roads.size(); ++b)
    for (std::size_t a = 0; a < roads.size(); ++a) {  // ends of b on a
      if (a == b || roads[b].alignment.closed) continue;
      for (const double s : {0.0, roads[b].alignment.length_m}) {
        const Vec2 p = evaluate(roads[b].alignment, s).p;
        if (!boxes[a].contains(p)) continue;
        const double on_a = nearest_s(roads[a].alignment, lines[a], p);
        if (distance(evaluate(roads[a].alignment, on_a).p, p) > 1e-6) continue;
        add_arm(plan, p, {a, on_a});
        add_arm(plan, p, {b, s});
      }
    }
  for (std::size_t b = 1; b < roads.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      if (!boxes[a].overlaps(boxes[b])) continue;
      for (const AlignmentCrossing& c : crossings(roads[a].alignment, lines[a], roads[b].alignment, lines[b])) {
        const AlignmentPoint pa = evaluate(roads[a].alignment, c.s_a_m), pb = evaluate(roads[b].alignment, c.s_b_m);
        const std::optional<std::size_t> over = rule(a, b);
        if (!over) {
          add_arm(plan, pa.p, {a, c.s_a_m});
          add_arm(plan, pa.p, {b, c.s_b_m});
          continue;
        }
        const std::size_t under = *over == a ? b : a;
        const double s_over = *over == a ? c.s_a_m : c.s_b_m, s_under = *over == a ? c.s_b_m : c.s_a_m;
        const double sine = std::abs(std::sin(pa.heading_rad - pb.heading_rad)), cosine = std::sqrt(1.0 - sine * sine);
        add_bridge(
            plan,
            {.over = *over,
             .s_over_m = s_over,
             .half_length_m =
                 (0.5 * roads[under].width_at(s_under) + 0.5 * roads[*over].width_at(s_over) * cosine) / sine + 5.0,
             .under = {{under, s_under, s_over}}});
      }
    }
}

void check_preset_size(double size_m, double least_m, double most_m) {
  if (!(size_m >= least_m && size_m <= most_m) || std::fmod(size_m, 10.0) != 0.0)
    throw OptionError(fmt::format("size is {} m, need a multiple of 10 m between {} and {}", size_m, least_m, most_m));
}

std::string site_name(const SitePlan& plan, std::uint64_t seed) {
  return plan.osm ? plan.name : fmt::format("{} {}", plan.name, seed);
}

int surface_priority(const SitePlan& plan, std::size_t road) {
  return 2 * road_rank(plan.roads[road].highway) + (road == plan.circuit || plan.roads[road].roundabout ? 1 : 0);
}

std::vector<Stretch> whole_roads(const SitePlan& plan) {
  std::vector<Stretch> stretches;
  stretches.reserve(plan.roads.size());
  for (std::size_t r = 0; r < plan.roads.size(); ++r) stretches.push_back({r, 0.0, plan.roads[r].alignment.length_m});
  return stretches;
}

bool on_bridge(const SitePlan& plan, std::size_t road, double s_m) {
  return std::any_of(plan.bridges.begin(), plan.bridges.end(), [&](const PlannedBridge& b) {
    return b.over == road && std::abs(s_m - b.s_over_m) <= b.half_length_m;
  });
}

bool is_fast(const PlannedRoad& road) {
  return is_raceway(road.highway) || road.highway == "motorway" || road.highway == "motorway_link";
}

Ring rectangle(Vec2 center, double heading, double half_length, double half_width) {
  const Vec2 along{std::cos(heading), std::sin(heading)};
  const Vec2 u = along * half_length, v = left_normal(along) * half_width;
  return {center - u - v, center + u - v, center + u + v, center - u + v};
}

}  // namespace orthodrive::synth
