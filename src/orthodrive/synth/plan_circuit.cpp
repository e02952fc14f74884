#include <fmt/format.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/synth/plan_presets.hpp"
#include "orthodrive/synth/planner.hpp"
#include "orthodrive/synth/trackside.hpp"

namespace orthodrive::synth {
namespace {
constexpr double overhang = 0.06;  // as in a village

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
}  // namespace

SitePlan plan_circuit(double size_m, std::uint64_t seed) {
  if (!(size_m >= 500.0 && size_m <= 4000.0) || std::fmod(size_m, 10.0) != 0.0)
    throw OptionError(fmt::format("size is {} m, need a multiple of 10 m between 500 and 4000", size_m));
  Planner planner(size_m, seed);
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  const std::size_t track = add_track(planner, size_m);
  const Straight straight = start_straight(planner, planner.plan_.roads[track].alignment);
  const double half_track_m = 0.5 * planner.plan_.roads[track].width_m;

  // Pit lane: leaves the straight and comes back to it, 8 m of grass and wall beside it.
  const double pit_half_m = planner.random_.uniform(3.6, 4.6), pit_m = half_track_m + 8.0 + pit_half_m;
  const double taper_m = std::min(110.0, 0.24 * straight.length_m), pit_begin = 0.03 * straight.length_m,
               pit_end = 0.97 * straight.length_m;
  planner.add({.highway = "raceway",
               .name = "Pit lane",
               .width_m = 2.0 * pit_half_m,
               .lanes = 1,
               .oneway = true,
               .alignment = round_corners({{straight.at(pit_begin, 0.0), 0.0},
                                           {straight.at(pit_begin + taper_m, pit_m), 180.0},
                                           {straight.at(pit_end - taper_m, pit_m), 180.0},
                                           {straight.at(pit_end, 0.0), 0.0}},
                                          false)});
  // Round the circuit.
  const std::size_t ring =
      planner.add({.highway = "service",
                   .width_m = planner.true_width_m("service", 0, false),
                   .alignment = round_corners(
                       {corner(0.07, 0.085, 30, 50), corner(0.92, 0.08, 30, 50), corner(0.935, 0.40, 100, 200),
                        corner(0.925, 0.72, 60, 120), corner(0.83, 0.935, 30, 50), corner(0.52, 0.90, 100, 200),
                        corner(0.22, 0.915, 40, 80), corner(0.06, 0.83, 40, 80), corner(0.045, 0.45, 100, 200)},
                       true)});
  // Paddock: a road behind the pit buildings, lots on its far side.
  const double garages_m = pit_m + pit_half_m + 8.0, garages_depth_m = 12.0,
               paddock_road_m = garages_m + garages_depth_m + 9.0;
  const double mid = 0.5 * straight.length_m, half_paddock = 0.5 * (straight.length_m - 2.0 * taper_m) - 5.0;
  const double paddock_half_m = 0.5 * planner.true_width_m("service", 0, false);
  const std::size_t paddock =
      planner.add({.highway = "service",
                   .name = "Paddock",
                   .width_m = 2.0 * paddock_half_m,
                   .alignment = round_corners({{straight.at(mid - half_paddock, paddock_road_m), 0.0},
                                               {straight.at(mid + half_paddock, paddock_road_m), 0.0}},
                                              false)});
  // From the paddock past the garages to the pit lane.
  const double gate_m = mid + 0.93 * half_paddock;
  const Vec2 gate = straight.at(gate_m, paddock_road_m);
  planner.add(
      {.highway = "service",
       .width_m = 2.0 * paddock_half_m,
       .alignment = round_corners({{gate, 0.0}, {planner.nearest_point(1, straight.at(gate_m, pit_m)), 0.0}}, false)});
  // From outside over the circuit to the paddock.
  const std::size_t access = planner.add(planner.street(
      "unclassified", "Ringstrasse",
      {corner(-overhang, 0.64, 0, 1),
       corner(0.03, 0.635, 60, 120),
       corner(0.20, 0.62, 50, 80),
       corner(0.245, 0.50, 40, 80),
       corner(0.26, 0.36, 40, 80),
       {evaluate(planner.plan_.roads[paddock].alignment, 0.35 * planner.plan_.roads[paddock].alignment.length_m).p,
        0.0}}));
  // The spectators' car park in the valley, from the service road.
  const Vec2 park_end = planner.place(0.425, 0.66);
  const std::size_t park =
      planner.add(planner.street("service", "", {{planner.branch_point(ring, 0.425, 0.90), 0.0}, {park_end, 0.0}}));

  SitePlan plan = std::move(planner.plan_);
  plan.name = "Circuit", plan.circuit = track, plan.surroundings = Surroundings::country, plan.relief = 0.6;
  plan.round_corners_by_angle = true;
  find_junctions(plan, [&](std::size_t a, std::size_t b) -> std::optional<std::size_t> {
    if (a == track && b == access) return access;
    return std::nullopt;
  });
  // Where the pit lane lies on the straight its height is the straight's.
  const double pit_length_m = plan.roads[1].alignment.length_m, on_track_m = 0.9 * taper_m;
  plan.ties = {{1, track, 0.0, on_track_m, true},
               {1, track, on_track_m, pit_length_m - on_track_m, false},
               {1, track, pit_length_m - on_track_m, pit_length_m, true}};

  Random random(derive_seed(seed, 21));
  add_verges(plan, track, 16.0);
  add_run_off(plan, track, random);
  const double heading = std::atan2(straight.along.y, straight.along.x);
  // Apron before the garages, the garages, lots behind them: strips of two rows of bays with the aisle between.
  const auto lot = [&](double from, double to, double near_m, double depth_m) {
    return Polygon{{straight.at(from, near_m), straight.at(to, near_m), straight.at(to, near_m + depth_m),
                    straight.at(from, near_m + depth_m)},
                   {}};
  };
  plan.areas.push_back(
      {lot(mid - half_paddock, mid + half_paddock, pit_m, paddock_road_m + paddock_half_m + 1.0 - pit_m), Cover::paved,
       false});
  plan.buildings.push_back({straight.at(mid, garages_m + 0.5 * garages_depth_m),
                            heading,
                            0.8 * half_paddock,
                            0.5 * garages_depth_m,
                            8.0,
                            0.0,
                            RoofShape::flat,
                            {0.70f, 0.70f, 0.71f}});
  const double lots_m = paddock_road_m + paddock_half_m;
  const int paddock_rows = size_m >= 800.0 ? 2 : 1;
  for (int i = 0; i < paddock_rows; ++i)
    plan.parkings.push_back(lot(mid - 0.1 * half_paddock, mid + 0.9 * half_paddock, lots_m + 17.0 * i, 17.0));
  const Alignment& park_road = plan.roads[park].alignment;
  const AlignmentPoint begin = evaluate(park_road, 0.35 * park_road.length_m);
  const Vec2 down{std::cos(begin.heading_rad), std::sin(begin.heading_rad)};
  const double length_m = 0.62 * park_road.length_m, gap_m = 0.5 * plan.roads[park].width_m;
  for (const double side : {1.0, -1.0})
    for (int i = 0; i < (size_m >= 800.0 ? 2 : 1); ++i) {
      const Vec2 across = left_normal(down) * side, a = begin.p + across * (gap_m + 17.0 * i);
      plan.parkings.push_back({{a, a + down * length_m, a + down * length_m + across * 17.0, a + across * 17.0}, {}});
    }
  add_stands(plan, track, 4, random);
  return plan;
}

}  // namespace orthodrive::synth
