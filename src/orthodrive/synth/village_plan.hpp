#pragma once
// The plan of a synthetic village: exact roads, where they meet and where one crosses over another.
// Everything in synth/ works in local metres east and north of the site's south-west corner; make_village moves the
// results into the site CRS.

#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/synth/alignment.hpp"

namespace orthodrive::synth {

struct PlannedRoad {
  std::string highway, name;
  double width_m = 0.0;  ///< of the carriageway, constant along the road
  int lanes = 2;
  bool oneway = false;
  Alignment alignment;
};

struct PlannedJunction {
  struct Arm {
    std::size_t road = 0;
    double s_m = 0.0;
  };
  Vec2 p;
  std::vector<Arm> arms;
};

struct PlannedBridge {
  std::size_t over = 0, under = 0;  ///< roads
  double s_over_m = 0.0, s_under_m = 0.0;
  double half_length_m = 0.0;  ///< of the deck, along the upper road
};

struct VillagePlan {
  double size_m = 0.0;
  std::vector<PlannedRoad> roads;  ///< road 0 is the closed circuit
  std::vector<PlannedJunction> junctions;
  std::vector<PlannedBridge> bridges;
  Polygon parking;  ///< four corners: along the service road, then away from it
};

constexpr std::size_t circuit_road = 0;

/// Roads of a village of that size: a circuit, a main road, a spine that bridges the circuit and crosses it at grade,
/// streets, dead ends, a one-way service loop at a parking area. Below 450 m only the larger ones.
[[nodiscard]] VillagePlan plan_village(double size_m, std::uint64_t seed);

/// Which road's surface is on top where two overlap at grade: larger wins.
[[nodiscard]] int surface_priority(const VillagePlan& plan, std::size_t road);
/// True on the deck of a bridge.
[[nodiscard]] bool on_bridge(const VillagePlan& plan, std::size_t road, double s_m);

}  // namespace orthodrive::synth
