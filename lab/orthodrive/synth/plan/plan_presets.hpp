// SPDX-License-Identifier: Apache-2.0
#pragma once
// The kinds of site: size and seed in, plan out. All throw OptionError for sizes that they cannot fill.

#include <cstdint>

#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// A village: a circuit (road 0), a main road, a spine that bridges the circuit and crosses it at grade, streets, dead
/// ends, a one-way service loop at a parking area. 200 - 4000 m; below 450 m only the larger roads.
[[nodiscard]] SitePlan plan_village(double size_m, std::uint64_t seed);

/// A motor-racing circuit (road 0, raceway, about three times the site's edge long) with pit lane, paddock, run-off
/// areas, a service road round it and an access road on a bridge over it. 500 - 4000 m.
[[nodiscard]] SitePlan plan_circuit(double size_m, std::uint64_t seed);

/// A diamond interchange: the two carriageways of a motorway (roads 0 and 1), a secondary road on a bridge over them,
/// four slip roads that end at T junctions or at roundabouts, by seed. 500 - 4000 m.
[[nodiscard]] SitePlan plan_junction(double size_m, std::uint64_t seed);

/// A region: towns, villages and hamlets on roads that cross in them, streets, farm lanes, and a motorway from edge to
/// edge (roads 0 and 1) with bridges over it and interchanges with roundabouts. 2 - 40 km.
[[nodiscard]] SitePlan plan_region(double size_m, std::uint64_t seed);

/// A region whose settlements are all towns that fill the grid: as many kilometres of road a square kilometre as the
/// map of Pardubice, a real town, has (10.5). 2 - 40 km.
[[nodiscard]] SitePlan plan_conurbation(double size_m, std::uint64_t seed);

/// American blocks: two families of wide streets (9 - 16 m) that cross, alleys, shops with car parks. 300 - 2000 m.
[[nodiscard]] SitePlan plan_grid(double size_m, std::uint64_t seed);

/// Asian lanes: irregular, 2.5 - 6 m wide, between dense houses and small or terraced fields. 200 - 2000 m.
[[nodiscard]] SitePlan plan_lanes(double size_m, std::uint64_t seed);

/// Farm and forest tracks of 2.5 - 4 m, a few roads, farms, hamlets, orchards, woods. 300 - 2000 m.
[[nodiscard]] SitePlan plan_farmland(double size_m, std::uint64_t seed);

/// Throws OptionError unless a multiple of 10 m from `least_m` to `most_m`.
void check_preset_size(double size_m, double least_m, double most_m);

}  // namespace orthodrive::synth
