// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/interchange.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::synth {
namespace {
/// The tangent polygon moved to the left; radii change so that arcs stay concentric.
std::vector<Corner> moved_left(const std::vector<Corner>& corners, double by_m) {
  std::vector<Corner> moved;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 in = normalized(corners[i].p - corners[i > 0 ? i - 1 : 0].p);
    const Vec2 out = normalized(corners[std::min(i + 1, corners.size() - 1)].p - corners[i].p);
    if (i == 0 || i + 1 == corners.size()) {
      moved.push_back({corners[i].p + left_normal(i == 0 ? out : in) * by_m, corners[i].radius_m});
      continue;
    }
    const Vec2 bisector = normalized(left_normal(in) + left_normal(out));
    const double turn = cross(in, out) > 0.0 ? 1.0 : -1.0;
    moved.push_back(
        {corners[i].p + bisector * (by_m / dot(bisector, left_normal(in))), corners[i].radius_m - turn * by_m});
  }
  return moved;
}

/// A place relative to a road: along it and to its right.
Vec2 beside(const Alignment& a, double s_m, double right_m) {
  const AlignmentPoint q = evaluate(a, s_m);
  return q.p - Vec2{-std::sin(q.heading_rad), std::cos(q.heading_rad)} * right_m;
}

/// Exit (from the carriageway to the head) or entry (from the head to the carriageway), on the right of `main`.
Alignment slip_road(const Alignment& main, double s_bridge, const Head& head, const InterchangeSizes& sizes,
                    bool exit) {
  const double sign = exit ? -1.0 : 1.0;
  constexpr double flat_slope = 0.09;  // 5 degrees
  const Vec2 nose = beside(main, s_bridge + sign * sizes.reach_m, 0.0);
  // The last corner stands so that the slip road meets the secondary road across.
  const double last_m = std::max(50.0, 0.16 * sizes.reach_m) + head.ring_radius_m;
  const Vec2 away = normalized(beside(main, s_bridge + sign * 100.0, 0.0) - beside(main, s_bridge, 0.0));
  const Vec2 last = head.p + away * last_m;
  std::vector<Corner> corners{{nose, 0.0}};
  // Along the carriageway, bent as it is: one leg would cut its bend and leave at twice the angle or never. The last
  // leg is long, the bend at its end needs it.
  for (const double share : {0.2, 0.4, 1.0}) {
    const double away_m = sizes.taper_m * share;
    corners.push_back({beside(main, s_bridge + sign * (sizes.reach_m - away_m), flat_slope * away_m), 260.0});
  }
  corners.insert(corners.end(), {{last, 90.0}, {head.end_from(last), 0.0}});
  if (!exit) std::reverse(corners.begin(), corners.end());
  return round_corners(corners, false);
}
}  // namespace

Motorway add_carriageways(Planner& planner, const std::vector<Corner>& axis, const std::array<std::string, 2>& names,
                          const CarriagewaySizes& sizes) {
  std::vector<Corner> back = moved_left(axis, sizes.apart_m);
  std::reverse(back.begin(), back.end());
  const auto carriageway = [&](const std::vector<Corner>& corners, const std::string& name) {
    return planner.add({.highway = "motorway",
                        .name = name,
                        .width_m = sizes.width_m,
                        .lanes = sizes.lanes,
                        .oneway = true,
                        .alignment = round_corners(corners, false),
                        .lanes_tagged = true});
  };
  return {axis, {carriageway(moved_left(axis, -sizes.apart_m), names[0]), carriageway(back, names[1])}, sizes.width_m};
}

Crossings place_heads(const SitePlan& plan, const Motorway& motorway, const Alignment& straight,
                      const InterchangeSizes& sizes, bool roundabouts) {
  std::array<AlignmentCrossing, 2> at;
  for (std::size_t i = 0; i < 2; ++i) at[i] = crossings(plan.roads[motorway.roads[i]].alignment, straight).front();
  Crossings result;
  for (std::size_t i = 0; i < 2; ++i) {
    result.s_bridge[i] = at[i].s_a_m;
    const double outwards = at[i].s_b_m < at[1 - i].s_b_m ? -1.0 : 1.0;
    const double head_s = at[i].s_b_m + outwards * (sizes.head_m + 0.5 * motorway.width_m);
    result.heads[i] = {evaluate(straight, head_s).p, roundabouts ? ring_radius_m : 0.0};
  }
  return result;
}

std::vector<Slip> add_slip_roads(Planner& planner, const Motorway& motorway, const Crossings& at,
                                 const InterchangeSizes& sizes) {
  const double width_m = planner.random_.uniform(5.8, 7.0);
  std::vector<Slip> slips;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t main = motorway.roads[i];
    for (const bool exit : {true, false})
      slips.push_back({planner.add({.highway = "motorway_link",
                                    .width_m = width_m,
                                    .lanes = 1,
                                    .oneway = true,
                                    .alignment = slip_road(planner.plan_.roads[main].alignment, at.s_bridge[i],
                                                           at.heads[i], sizes, exit),
                                    .lanes_tagged = true}),
                       main, exit});
  }
  return slips;
}

void add_ring(Planner& planner, const Head& head, const std::string& name) {
  planner.add({.highway = "secondary",
               .name = name,
               .width_m = planner.random_.uniform(6.6, 7.6),
               .lanes = 1,
               .oneway = true,
               .alignment = circle(head.p, head.ring_radius_m),
               .roundabout = true});
}

void add_ties(SitePlan& plan, const Slip& joining) {
  const auto [slip, main, exit] = joining;
  const Alignment &a = plan.roads[slip].alignment, &m = plan.roads[main].alignment;
  const double apart_m = 0.5 * (plan.roads[slip].width_m + plan.roads[main].width_m) + 1.0;
  double on_m = 0.0;
  for (; on_m < 0.5 * a.length_m; on_m += 2.0) {
    const Vec2 p = evaluate(a, exit ? on_m : a.length_m - on_m).p;
    if (distance(p, evaluate(m, nearest_s(m, p)).p) > apart_m) break;
  }
  if (exit)
    plan.ties.push_back({slip, main, 0.0, on_m, true});
  else
    plan.ties.push_back({slip, main, a.length_m - on_m, a.length_m, true});
}

}  // namespace orthodrive::synth
