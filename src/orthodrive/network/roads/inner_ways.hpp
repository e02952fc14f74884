// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ways inside a joined junction, and where one comes to on them.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "orthodrive/network/line/connecting_line.hpp"
#include "orthodrive/network/line/network_plan.hpp"
#include "orthodrive/network/roads/gates.hpp"
#include "orthodrive/network/roads/turn_rules.hpp"

namespace orthodrive::network {

// Sharper than this is turning round: between the prongs of a fork, or into a road that leads back to the junction that
// one comes from. Allowed only where there is no other way on.
inline constexpr double max_turn_rad = 150.0 * std::numbers::pi / 180.0;

/// A piece of way between two vertices of a joined junction.
struct InnerWay {
  VertexIndex vertex0, vertex1;
  Leg leg;                               ///< from vertex0 to vertex1
  std::vector<std::int64_t> ways;        ///< OSM's, from vertex0 to vertex1
  std::vector<std::int64_t> nodes;       ///< OSM's, between one way and the next
  bool forward = true, backward = true;  ///< whether one may drive from vertex0 to vertex1, and back
  Vec2 direction0, direction1;           ///< at either end, driving from vertex0 to vertex1
};
/// A vertex of a joined junction, and how one has come there.
struct Arrival {
  VertexIndex vertex;
  DrivenWay driven;
  Vec2 direction;                ///< in which one drives
  const InnerWay* on = nullptr;  ///< null: by the road that one comes from
  bool turned = false;           ///< one had to turn round on the way
  std::vector<Leg> legs;         ///< the inner ways that one has come
};

[[nodiscard]] inline bool turns_round(Vec2 in, Vec2 out) { return std::abs(angle_between(in, out)) > max_turn_rad; }

[[nodiscard]] std::int64_t node_of(const NetworkPlan& plan, VertexIndex vertex);

/// Of every junction.
[[nodiscard]] std::vector<std::vector<InnerWay>> inner_ways(const NetworkPlan& plan, std::size_t junctions);

/// Where one is after an inner way; none where that is forbidden.
[[nodiscard]] std::optional<DrivenWay> driven_over(const TurnRules& rules, DrivenWay driven, std::int64_t node,
                                                   const InnerWay& inner, bool forward);

/// The ways from an end's vertex to its cut, as if they lay inside. Where the map tells no restriction it is the way at
/// the cut alone: those of crossings without a node then miss what lies before the cut (docs/network.md, Limits).
[[nodiscard]] InnerWay way_to_cut(const NetworkPlan& plan, const TurnRules& rules, const JunctionEnd& end);

/// Where one is at the vertex when one comes from the road of an end.
[[nodiscard]] std::optional<DrivenWay> driven_in(const TurnRules& rules, const InnerWay& to_cut);

/// Where one can drive to from a road's end on the inner ways of a joined junction. First what needs no turning round.
/// A vertex is reached once from each inner way and with each state of the restrictions: their number bounds it.
[[nodiscard]] std::vector<Arrival> arrivals_from(const NetworkPlan& plan, const std::vector<InnerWay>& inside,
                                                 const TurnRules& rules, Arrival start);

}  // namespace orthodrive::network
