// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/plan/planner.hpp"
#include "orthodrive/synth/plan/trackside.hpp"

namespace orthodrive::synth {
namespace {
constexpr double circuit_overhang = 0.06;  // as in a village

/// Start and finish straight (the first element) in the south, then counter-clockwise; a chicane in the east, a hairpin
/// in the north, a valley towards the middle where the spectators park.
std::size_t add_track(Planner& planner, double size_m) {
  const auto corner = [&](double u, double v, double r0, double r1) {
    const Vec2 p = planner.jittered(u, v);
    return Corner{p, planner.random_.uniform(r0, r1) * std::min(1.0, size_m / 1000.0)};
  };
  const std::vector<Corner> ring{corner(0.15, 0.17, 60, 90), corner(0.84, 0.17, 55, 90), corner(0.855, 0.42, 40, 80),
                                 corner(0.70, 0.50, 40, 70), corner(0.82, 0.66, 50, 90), corner(0.75, 0.85, 28, 45),
                                 corner(0.54, 0.77, 45, 80), corner(0.52, 0.55, 60, 90), corner(0.35, 0.51, 60, 90),
                                 corner(0.31, 0.80, 30, 45), corner(0.15, 0.78, 40, 60), corner(0.12, 0.45, 150, 300)};
  return planner.add({.highway = "raceway",
                      .name = "Circuit",
                      .width_m = planner.random_.uniform(10.5, 13.5),
                      .lanes = 1,
                      .oneway = true,
                      .alignment = round_corners(ring, true)});
}

/// The start straight as a frame: metres along it and inwards.
struct Straight {
  Vec2 start, along, inward;
  double length_m = 0.0;
  [[nodiscard]] Vec2 at(double along_m, double inward_m) const { return start + along * along_m + inward * inward_m; }
};

Straight start_straight(const Planner& planner, const Alignment& track) {
  const AlignmentElement& first = track.elements.front();
  const Vec2 along{std::cos(first.heading_rad), std::sin(first.heading_rad)};
  const Vec2 left = left_normal(along);
  const bool inward_is_left = dot(planner.place(0.5, 0.5) - first.start, left) > 0.0;  // else mirrored: clockwise
  return {first.start, along, inward_is_left ? left : left * -1.0, first.length_m};
}

/// The pit lane leaves the straight and comes back to it, with 8 m of grass and wall beside the track.
struct PitLane {
  std::size_t road = 0;
  double half_m = 0.0;    ///< half its width
  double inward_m = 0.0;  ///< of its middle from that of the track
  double taper_m = 0.0;   ///< along the straight, until it is that far away
};

PitLane add_pit_lane(Planner& planner, const Straight& straight, double half_track_m) {
  PitLane pit;
  pit.half_m = planner.random_.uniform(3.6, 4.6), pit.inward_m = half_track_m + 8.0 + pit.half_m;
  pit.taper_m = std::min(110.0, 0.24 * straight.length_m);
  const double begin = 0.03 * straight.length_m, end = 0.97 * straight.length_m;
  pit.road = planner.add({.highway = "raceway",
                          .name = "Pit lane",
                          .width_m = 2.0 * pit.half_m,
                          .lanes = 1,
                          .oneway = true,
                          .alignment = round_corners({{straight.at(begin, 0.0), 0.0},
                                                      {straight.at(begin + pit.taper_m, pit.inward_m), 180.0},
                                                      {straight.at(end - pit.taper_m, pit.inward_m), 180.0},
                                                      {straight.at(end, 0.0), 0.0}},
                                                     false)});
  return pit;
}

/// Round the circuit.
std::size_t add_service_road(Planner& planner) {
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  return planner.add({.highway = "service",
                      .width_m = planner.true_width_m("service", 0, false),
                      .alignment = round_corners(
                          {corner(0.07, 0.085, 30, 50), corner(0.92, 0.08, 30, 50), corner(0.935, 0.40, 100, 200),
                           corner(0.925, 0.72, 60, 120), corner(0.83, 0.935, 30, 50), corner(0.52, 0.90, 100, 200),
                           corner(0.22, 0.915, 40, 80), corner(0.06, 0.83, 40, 80), corner(0.045, 0.45, 100, 200)},
                          true)});
}

/// The paddock: a road behind the garages. Distances inwards from the middle of the track, along the straight.
struct Paddock {
  std::size_t road = 0;
  double garages_m = 0.0, garages_depth_m = 12.0, road_m = 0.0, half_width_m = 0.0;
  double middle_m = 0.0, half_length_m = 0.0;
};

/// With a road past the garages to the pit lane.
Paddock add_paddock(Planner& planner, const Straight& straight, const PitLane& pit) {
  Paddock paddock;
  paddock.garages_m = pit.inward_m + pit.half_m + 8.0;
  paddock.road_m = paddock.garages_m + paddock.garages_depth_m + 9.0;
  paddock.middle_m = 0.5 * straight.length_m;
  paddock.half_length_m = 0.5 * (straight.length_m - 2.0 * pit.taper_m) - 5.0;
  paddock.half_width_m = 0.5 * planner.true_width_m("service", 0, false);
  const double mid = paddock.middle_m, half = paddock.half_length_m;
  paddock.road = planner.add(
      {.highway = "service",
       .name = "Paddock",
       .width_m = 2.0 * paddock.half_width_m,
       .alignment = round_corners(
           {{straight.at(mid - half, paddock.road_m), 0.0}, {straight.at(mid + half, paddock.road_m), 0.0}}, false)});
  const double gate_m = mid + 0.93 * half;
  const Vec2 gate = straight.at(gate_m, paddock.road_m);
  const Vec2 at_pit = planner.nearest_point(pit.road, straight.at(gate_m, pit.inward_m));
  planner.add({.highway = "service",
               .width_m = 2.0 * paddock.half_width_m,
               .alignment = round_corners({{gate, 0.0}, {at_pit, 0.0}}, false)});
  return paddock;
}

/// From outside over the circuit to the paddock.
std::size_t add_access_road(Planner& planner, std::size_t paddock) {
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  const Alignment& end = planner.plan_.roads[paddock].alignment;
  return planner.add(planner.street("unclassified", "Ringstrasse",
                                    {corner(-circuit_overhang, 0.64, 0, 1),
                                     corner(0.03, 0.635, 60, 120),
                                     corner(0.20, 0.62, 50, 80),
                                     corner(0.245, 0.50, 40, 80),
                                     corner(0.26, 0.36, 40, 80),
                                     {evaluate(end, 0.35 * end.length_m).p, 0.0}}));
}

/// From the service road to the spectators' car park in the valley.
std::size_t add_car_park_road(Planner& planner, std::size_t service_road) {
  const Vec2 end = planner.place(0.425, 0.66);
  return planner.add(
      planner.street("service", "", {{planner.branch_point(service_road, 0.425, 0.90), 0.0}, {end, 0.0}}));
}

/// Where the pit lane lies on the straight its height is the straight's.
void tie_pit_lane(SitePlan& plan, const PitLane& pit, std::size_t track) {
  const double length_m = plan.roads[pit.road].alignment.length_m, on_track_m = 0.9 * pit.taper_m;
  plan.ties = {{pit.road, track, 0.0, on_track_m, true},
               {pit.road, track, on_track_m, length_m - on_track_m, false},
               {pit.road, track, length_m - on_track_m, length_m, true}};
}

constexpr double lot_depth_m = 17.0;  // two rows of bays with the aisle between

int rows_of_lots(double size_m) { return size_m >= 800.0 ? 2 : 1; }

/// Apron before the garages, the garages, lots behind them.
void lay_out_paddock(SitePlan& plan, const Straight& straight, const PitLane& pit, const Paddock& paddock) {
  const double mid = paddock.middle_m, half = paddock.half_length_m;
  const auto lot = [&](double from, double to, double near_m, double depth_m) {
    return Polygon{{straight.at(from, near_m), straight.at(to, near_m), straight.at(to, near_m + depth_m),
                    straight.at(from, near_m + depth_m)},
                   {}};
  };
  plan.areas.push_back(
      {lot(mid - half, mid + half, pit.inward_m, paddock.road_m + paddock.half_width_m + 1.0 - pit.inward_m),
       Cover::paved, false});
  plan.buildings.push_back({straight.at(mid, paddock.garages_m + 0.5 * paddock.garages_depth_m),
                            std::atan2(straight.along.y, straight.along.x),
                            0.8 * half,
                            0.5 * paddock.garages_depth_m,
                            8.0,
                            0.0,
                            RoofShape::flat,
                            {0.70f, 0.70f, 0.71f},
                            0,
                            Use::works});
  const double lots_m = paddock.road_m + paddock.half_width_m;
  for (int i = 0; i < rows_of_lots(plan.size_m); ++i)
    plan.parkings.push_back(lot(mid - 0.1 * half, mid + 0.9 * half, lots_m + lot_depth_m * i, lot_depth_m));
}

/// The spectators' car park: lots on both sides of its road.
void add_car_park(SitePlan& plan, std::size_t road) {
  const Alignment& line = plan.roads[road].alignment;
  const AlignmentPoint begin = evaluate(line, 0.35 * line.length_m);
  const Vec2 down{std::cos(begin.heading_rad), std::sin(begin.heading_rad)};
  const double length_m = 0.62 * line.length_m, gap_m = 0.5 * plan.roads[road].width_m;
  for (const double side : {1.0, -1.0})
    for (int i = 0; i < rows_of_lots(plan.size_m); ++i) {
      const Vec2 across = left_normal(down) * side, a = begin.p + across * (gap_m + lot_depth_m * i);
      plan.parkings.push_back(
          {{a, a + down * length_m, a + down * length_m + across * lot_depth_m, a + across * lot_depth_m}, {}});
    }
}
}  // namespace

SitePlan plan_circuit(double size_m, std::uint64_t seed) {
  if (!(size_m >= 500.0 && size_m <= 4000.0) || std::fmod(size_m, 10.0) != 0.0)
    throw OptionError(fmt::format("size is {} m, need a multiple of 10 m between 500 and 4000", size_m));
  // Draws follow each other in this order: the seed's site would change with it.
  Planner planner(size_m, seed);
  const std::size_t track = add_track(planner, size_m);
  const Straight straight = start_straight(planner, planner.plan_.roads[track].alignment);
  const PitLane pit = add_pit_lane(planner, straight, 0.5 * planner.plan_.roads[track].width_m);
  const std::size_t service_road = add_service_road(planner);
  const Paddock paddock = add_paddock(planner, straight, pit);
  const std::size_t access = add_access_road(planner, paddock.road);
  const std::size_t car_park_road = add_car_park_road(planner, service_road);

  SitePlan plan = std::move(planner.plan_);
  plan.name = "Circuit", plan.circuit = track, plan.surroundings = Surroundings::country, plan.relief = 0.6;
  plan.round_corners_by_angle = true;
  find_junctions(plan, [&](std::size_t a, std::size_t b) -> std::optional<std::size_t> {
    if (a == track && b == access) return access;
    return std::nullopt;
  });
  tie_pit_lane(plan, pit, track);
  Random random(derive_seed(seed, 21));
  add_verges(plan, track, 16.0);
  add_run_off(plan, track, random);
  lay_out_paddock(plan, straight, pit, paddock);
  add_car_park(plan, car_park_road);
  add_stands(plan, track, 4, random);
  return plan;
}

}  // namespace orthodrive::synth
