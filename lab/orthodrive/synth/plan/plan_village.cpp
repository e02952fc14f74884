// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/synth/plan/plan_presets.hpp"
#include "orthodrive/synth/plan/planner.hpp"

namespace orthodrive::synth {
namespace {
constexpr double streets_from_size_m = 450.0;  // below, streets of 5 m width would touch each other
constexpr double overhang = 0.06;              // roads that leave the site go on by this share of its size

std::size_t add_circuit(Planner& planner) {
  constexpr int corners = 10;  // even, so that straights face each other north and south, where the spine crosses
  std::vector<Corner> ring;
  for (int i = 0; i < corners; ++i) {
    const double angle = std::numbers::pi * (0.5 + (2.0 * i + 1.0) / corners) + planner.random_.uniform(-0.06, 0.06);
    // In and out in turn: left bends and right bends.
    const double radius = 0.31 + (i % 2 == 0 ? 0.022 : -0.022) + planner.random_.uniform(-0.045, 0.045);
    ring.push_back({planner.place(0.5 + 1.08 * radius * std::cos(angle), 0.54 + 0.96 * radius * std::sin(angle)),
                    planner.random_.uniform(50.0, 220.0)});
  }
  return planner.add({.highway = "tertiary",
                      .name = "Circuit",
                      .width_m = planner.random_.uniform(8.0, 9.5),
                      .alignment = round_corners(ring, true)});
}

/// The larger roads, by their index.
struct Roads {
  std::size_t circuit = 0, main = 0, spine = 0, street = 0;
};

Roads add_larger_roads(Planner& planner) {
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  Roads roads;
  roads.circuit = add_circuit(planner);
  roads.main = planner.add(
      planner.street("secondary", "Hauptstrasse",
                     {corner(-overhang, 0.09, 0, 1), corner(0.15, 0.055, 120, 260), corner(0.36, 0.105, 120, 260),
                      corner(0.62, 0.06, 120, 260), corner(0.82, 0.10, 120, 260), corner(1.0 + overhang, 0.07, 0, 1)}));
  // From the north over the circuit, through the village, across the circuit at grade, to the main road.
  roads.spine = planner.add(planner.street("tertiary", "Dorfstrasse",
                                           {corner(0.47, 1.0 + overhang, 0, 1),
                                            corner(0.505, 0.95, 60, 140),
                                            corner(0.495, 0.73, 60, 140),
                                            corner(0.515, 0.56, 50, 120),
                                            corner(0.485, 0.36, 50, 120),
                                            corner(0.505, 0.15, 60, 140),
                                            {planner.branch_point(roads.main, 0.50, 0.08), 0.0}}));
  roads.street = planner.add(planner.street("residential", "Gartengasse",
                                            {{planner.branch_point(roads.circuit, 0.19, 0.64), 0.0},
                                             corner(0.29, 0.60, 30, 70),
                                             corner(0.40, 0.51, 30, 70),
                                             corner(0.61, 0.51, 30, 70),
                                             corner(0.70, 0.60, 30, 70),
                                             {planner.branch_point(roads.circuit, 0.81, 0.64), 0.0}}));
  return roads;
}

/// A one-way service loop with a parking area beside it.
void add_service_loop(Planner& planner, std::size_t spine, double size_m) {
  const std::size_t lane = planner.add({.highway = "service",
                                        .width_m = planner.true_width_m("service", 0, true),
                                        .lanes = 1,
                                        .oneway = true,
                                        .alignment = round_corners({{planner.branch_point(spine, 0.49, 0.41), 0.0},
                                                                    {planner.place(0.42, 0.41), 8.0},
                                                                    {planner.place(0.42, 0.30), 8.0},
                                                                    {planner.branch_point(spine, 0.49, 0.30), 0.0}},
                                                                   false)});
  const double gap = 0.5 * planner.plan_.roads[lane].width_m / size_m, depth = 17.0 / size_m;
  planner.plan_.parkings = {
      Polygon{{planner.place(0.42 - gap, 0.322), planner.place(0.42 - gap, 0.388),
               planner.place(0.42 - gap - depth, 0.388), planner.place(0.42 - gap - depth, 0.322)},
              {}}};
}

/// Residential streets, dead ends and drives.
void add_streets(Planner& planner, const Roads& roads) {
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  const std::size_t west = planner.add(planner.street("residential", "Bachweg",
                                                      {{planner.branch_point(roads.circuit, 0.31, 0.29), 0.0},
                                                       corner(0.33, 0.36, 25, 50),
                                                       corner(0.305, 0.46, 25, 50),
                                                       {planner.branch_point(roads.street, 0.34, 0.56), 0.0}}));
  const std::size_t old_street = planner.add(planner.street("residential", "Kirchgasse",
                                                            {{planner.branch_point(roads.spine, 0.49, 0.35), 0.0},
                                                             corner(0.61, 0.36, 25, 50),
                                                             corner(0.665, 0.44, 25, 50),
                                                             {planner.branch_point(roads.street, 0.66, 0.56), 0.0}}));
  planner.plan_.roads[old_street].surface = "sett";
  planner.add(planner.street("residential", "Am Hang",
                             {{planner.branch_point(roads.street, 0.42, 0.51), 0.0},
                              corner(0.405, 0.60, 20, 40),
                              corner(0.37, 0.68, 20, 40),
                              corner(0.41, 0.76, 0, 1)}));
  planner.add(planner.street(
      "residential", "Lindenweg",
      {{planner.branch_point(roads.spine, 0.50, 0.68), 0.0}, corner(0.58, 0.665, 20, 40), corner(0.655, 0.725, 0, 1)}));
  planner.add(
      planner.street("service", "", {{planner.branch_point(west, 0.315, 0.42), 0.0}, corner(0.25, 0.43, 0, 1)}));
  planner.add(planner.street(
      "service", "",
      {{planner.branch_point(roads.circuit, 0.80, 0.42), 0.0}, corner(0.86, 0.40, 15, 30), corner(0.91, 0.33, 0, 1)}));
}

}  // namespace

SitePlan plan_village(double size_m, std::uint64_t seed) {
  if (!(size_m >= 200.0 && size_m <= 4000.0) || std::fmod(size_m, 10.0) != 0.0)
    throw OptionError(fmt::format("size is {} m, need a multiple of 10 m between 200 and 4000", size_m));
  // Draws follow each other in this order: the seed's site would change with it.
  Planner planner(size_m, seed);
  const auto corner = [&](double u, double v, double r0, double r1) { return planner.corner(u, v, r0, r1); };
  const Roads roads = add_larger_roads(planner);
  add_service_loop(planner, roads.spine, size_m);
  const std::size_t field_road = planner.add(planner.street("unclassified", "Feldweg",
                                                            {{planner.branch_point(roads.circuit, 0.20, 0.44), 0.0},
                                                             corner(0.10, 0.40, 40, 90),
                                                             corner(-overhang, 0.46, 0, 1)}));
  planner.plan_.roads[field_road].surface = "fine_gravel";
  if (size_m >= streets_from_size_m) add_streets(planner, roads);

  SitePlan plan = std::move(planner.plan_);
  plan.name = "Village", plan.circuit = roads.circuit;
  // The spine's first crossing with the circuit is the bridge.
  find_junctions(plan, [&](std::size_t a, std::size_t b) -> std::optional<std::size_t> {
    if (a == roads.circuit && b == roads.spine && plan.bridges.empty()) return roads.spine;
    return std::nullopt;
  });
  return plan;
}

}  // namespace orthodrive::synth
