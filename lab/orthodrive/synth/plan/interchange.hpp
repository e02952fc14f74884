// SPDX-License-Identifier: Apache-2.0
#pragma once
// Motorways and their diamond interchanges: what the plans of a junction and of a region share.

#include <array>
#include <string>
#include <vector>

#include "orthodrive/synth/plan/planner.hpp"

namespace orthodrive::synth {

constexpr double strip_m = 0.75, lane_m = 3.75;  ///< RAA 2008: edge strip at the median, lane
constexpr double ring_radius_m = 17.0;           ///< of a roundabout's centre line: 40 m across with 7 m of carriageway

/// The two carriageways, in the direction of travel, on both sides of an axis.
struct Motorway {
  std::vector<Corner> axis;
  std::array<std::size_t, 2> roads{};
  double width_m = 0.0;  ///< of a carriageway
};

struct CarriagewaySizes {
  int lanes = 2;
  double width_m = 0.0, apart_m = 0.0;  ///< of a carriageway; of its line from the axis
};
/// Adds both carriageways of an axis, the one along it first. Traffic keeps right.
Motorway add_carriageways(Planner& planner, const std::vector<Corner>& axis, const std::array<std::string, 2>& names,
                          const CarriagewaySizes& sizes);

/// Where a slip road meets the secondary road: a T junction, or a roundabout whose ring it ends on.
struct Head {
  Vec2 p;
  double ring_radius_m = 0.0;
  [[nodiscard]] Vec2 end_from(Vec2 corner) const { return p + normalized(corner - p) * ring_radius_m; }
};

struct InterchangeSizes {
  double reach_m = 0.0;  ///< from the bridge to where slip roads leave the motorway
  double taper_m = 0.0;  ///< length of the flat first leg
  double head_m = 0.0;   ///< from the motorway to the heads
};

/// Where a secondary road crosses each carriageway, and the heads beside it.
struct Crossings {
  std::array<double, 2> s_bridge{};
  std::array<Head, 2> heads;
};

/// `straight`: the secondary road's line over the motorway.
[[nodiscard]] Crossings place_heads(const SitePlan& plan, const Motorway& motorway, const Alignment& straight,
                                    const InterchangeSizes& sizes, bool roundabouts);

struct Slip {
  std::size_t road = 0, main = 0;
  bool exit = false;
};
/// Adds an exit and an entry at each carriageway.
std::vector<Slip> add_slip_roads(Planner& planner, const Motorway& motorway, const Crossings& at,
                                 const InterchangeSizes& sizes);
/// Adds the ring of a head. Needs one with a radius.
void add_ring(Planner& planner, const Head& head, const std::string& name);
/// The stretches of a slip road on and off its carriageway. On it: their surfaces overlap.
void add_ties(SitePlan& plan, const Slip& slip);

}  // namespace orthodrive::synth
