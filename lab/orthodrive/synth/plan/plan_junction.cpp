// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/synth/plan/interchange.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/plan/trackside.hpp"

namespace orthodrive::synth {
namespace {
/// Metres from the middle of the site, turned by seed. Never mirrored: traffic keeps right.
struct Frame {
  Vec2 center;
  double turn_rad = 0.0;
  [[nodiscard]] Vec2 at(double x, double y) const {
    const double c = std::cos(turn_rad), s = std::sin(turn_rad);
    return center + Vec2{c * x - s * y, s * x + c * y};
  }
};

Motorway add_motorway(Planner& planner, const Frame& frame, double size_m) {
  Random& random = planner.random_;
  const auto wobble = [&](double share) { return random.uniform(-share, share) * size_m; };
  const int lanes = 2 + static_cast<int>(random.below(2));
  const double shoulder_m = random.uniform(2.0, 3.4), width_m = strip_m + lanes * lane_m + shoulder_m,
               median_m = random.uniform(3.5, 6.0), apart_m = 0.5 * (median_m + width_m);
  const std::vector<Corner> axis{{frame.at(-0.9 * size_m, wobble(0.06)), 0.0},
                                 {frame.at(-0.32 * size_m, wobble(0.025)), random.uniform(0.7, 1.1) * size_m},
                                 {frame.at(0.32 * size_m, wobble(0.025)), random.uniform(0.7, 1.1) * size_m},
                                 {frame.at(0.9 * size_m, wobble(0.06)), 0.0}};
  return add_carriageways(planner, axis, {"A 9", "A 9"}, {lanes, width_m, apart_m});
}

/// The line of the secondary road: straight over the motorway, bent beyond the heads.
struct SecondaryLine {
  Frame frame;
  double size_m = 0.0, lean = 0.0, far_bend = 0.0, bend_m = 0.0, bend_radius_m = 0.0;
  [[nodiscard]] Vec2 across(double y) const { return frame.at(lean * y, y); }
  [[nodiscard]] Vec2 beyond(double sign) const {
    return frame.at(sign * (lean * bend_m + far_bend * 0.5 * size_m), sign * 0.85 * size_m);
  }
  [[nodiscard]] Alignment straight() const {
    return round_corners({{across(-bend_m), 0.0}, {across(bend_m), 0.0}}, false);
  }
};

SecondaryLine draw_secondary_line(const Frame& frame, double size_m, Random& random) {
  SecondaryLine line{frame, size_m};
  line.lean = random.uniform(-0.18, 0.18);
  line.far_bend = random.uniform(0.2, 0.3) * (random.below(2) ? 1.0 : -1.0);
  line.bend_m = 0.31 * size_m, line.bend_radius_m = 0.22 * size_m;
  return line;
}

/// The secondary road, in one piece or in three with the rings between. Returns the piece with the bridge.
std::size_t add_secondary_road(Planner& planner, const SecondaryLine& line, const std::array<Head, 2>& heads,
                               bool roundabouts) {
  const double width_m = planner.true_width_m("secondary", 0, false);
  const auto piece = [&](const std::vector<Corner>& corners) {
    return planner.add({.highway = "secondary",
                        .name = "Landesstrasse",
                        .width_m = width_m,
                        .alignment = round_corners(corners, false)});
  };
  if (!roundabouts)
    return piece({{line.beyond(-1.0), 0.0},
                  {line.across(-line.bend_m), line.bend_radius_m},
                  {line.across(line.bend_m), line.bend_radius_m},
                  {line.beyond(1.0), 0.0}});
  const std::size_t over = piece({{heads[0].end_from(heads[1].p), 0.0}, {heads[1].end_from(heads[0].p), 0.0}});
  for (std::size_t i = 0; i < 2; ++i) {
    const double sign = i == 0 ? -1.0 : 1.0;
    const Vec2 bend = line.across(sign * line.bend_m);
    piece({{heads[i].end_from(bend), 0.0}, {bend, line.bend_radius_m}, {line.beyond(sign), 0.0}});
    add_ring(planner, heads[i], i == 0 ? "Kreisel Sued" : "Kreisel Nord");
  }
  return over;
}

/// A lane to a farm on each side, from the secondary road beyond the heads. Returns the last one.
std::size_t add_farm_lanes(Planner& planner, const SecondaryLine& line, std::size_t over, bool roundabouts,
                           double lane_side) {
  Random& random = planner.random_;
  const Frame& frame = line.frame;
  const double size_m = line.size_m, bend_m = line.bend_m;
  std::size_t farm_lane = 0;
  for (const double sign : {-1.0, 1.0}) {
    const std::size_t from = roundabouts ? over + (sign < 0.0 ? 1 : 3) : over;
    const Alignment& a = planner.plan_.roads[from].alignment;
    const Vec2 begin = evaluate(a, nearest_s(a, line.across(sign * (bend_m + 0.03 * size_m)))).p;
    const double side = sign * lane_side;
    farm_lane = planner.add(
        planner.street("unclassified", sign < 0.0 ? "Hofweg" : "Waldweg",
                       {{begin, 0.0},
                        {frame.at(side * 0.16 * size_m, sign * (bend_m + 0.06 * size_m)), random.uniform(40.0, 90.0)},
                        {frame.at(side * 0.30 * size_m, sign * (bend_m + 0.02 * size_m)), random.uniform(60.0, 120.0)},
                        {frame.at(side * 0.80 * size_m, sign * (bend_m + 0.10 * size_m)), 0.0}}));
  }
  return farm_lane;
}

/// Verges, grass in the rings, a wall in the median.
void lay_out_ground(SitePlan& plan, const Motorway& motorway, const std::vector<Slip>& slips,
                    const std::array<Head, 2>& heads, bool roundabouts) {
  for (const Slip& slip : slips) add_verges(plan, slip.road, 10.0);
  for (const std::size_t road : motorway.roads) add_verges(plan, road, 18.0);
  if (roundabouts)
    for (const Head& head : heads)
      plan.areas.push_back({{sample(circle(head.p, ring_radius_m), 2.0), {}}, Cover::meadow, false});
  const Alignment axis = round_corners(motorway.axis, false);
  plan.areas.push_back({{strip_along(axis, 0.0, axis.length_m, -0.3, 0.3), {}}, Cover::paved, false});
}

/// A commuters' car park beside a lane.
void add_car_park(SitePlan& plan, std::size_t road, double lane_side) {
  const PlannedRoad& lane = plan.roads[road];
  const AlignmentPoint q = evaluate(lane.alignment, 0.07 * plan.size_m);
  const Vec2 along{std::cos(q.heading_rad), std::sin(q.heading_rad)}, outward = left_normal(along) * (-lane_side);
  const Vec2 corner = q.p + outward * (0.5 * lane.width_m);
  plan.parkings.push_back(
      {{corner, corner + along * 40.0, corner + along * 40.0 + outward * 17.0, corner + outward * 17.0}, {}});
}
}  // namespace

SitePlan plan_junction(double size_m, std::uint64_t seed) {
  if (!(size_m >= 500.0 && size_m <= 4000.0) || std::fmod(size_m, 10.0) != 0.0)
    throw OptionError(fmt::format("size is {} m, need a multiple of 10 m between 500 and 4000", size_m));
  // Draws follow each other in this order: the seed's site would change with it.
  Planner planner(size_m, seed);
  Random& random = planner.random_;
  const Frame frame{{0.5 * size_m, 0.5 * size_m},
                    0.5 * std::numbers::pi * static_cast<double>(random.below(4)) + random.uniform(-0.3, 0.3)};
  const bool roundabouts = random.below(2) == 1;
  const Motorway motorway = add_motorway(planner, frame, size_m);
  const SecondaryLine line = draw_secondary_line(frame, size_m, random);
  const InterchangeSizes sizes{std::min(420.0, 0.38 * size_m), std::min(140.0, 0.15 * size_m),
                               std::max(66.0, std::min(100.0, 0.09 * size_m))};
  const Crossings at = place_heads(planner.plan_, motorway, line.straight(), sizes, roundabouts);
  const std::size_t over = add_secondary_road(planner, line, at.heads, roundabouts);
  const std::vector<Slip> slips = add_slip_roads(planner, motorway, at, sizes);
  const double lane_side = random.below(2) ? 1.0 : -1.0;
  const std::size_t farm_lane = add_farm_lanes(planner, line, over, roundabouts, lane_side);

  SitePlan plan = std::move(planner.plan_);
  plan.name = "Junction", plan.surroundings = Surroundings::country, plan.relief = 0.35;
  plan.round_corners_by_angle = true;
  find_junctions(plan, [&](std::size_t a, std::size_t b) -> std::optional<std::size_t> {
    if (b == over && plan.roads[a].highway == "motorway") return over;
    return std::nullopt;
  });
  const auto [main, opposite] = motorway.roads;
  plan.ties.push_back({opposite, main, 0.0, plan.roads[opposite].alignment.length_m, false});
  for (const Slip& slip : slips) add_ties(plan, slip);
  lay_out_ground(plan, motorway, slips, at.heads, roundabouts);
  add_car_park(plan, farm_lane, lane_side);
  return plan;
}

}  // namespace orthodrive::synth
