// SPDX-License-Identifier: Apache-2.0
#pragma once
// Gores: the paved and hatched area between one-way roads that leave a junction side by side, or come to it so.

#include <vector>

#include "orthodrive/network/line/network_plan.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

inline constexpr const char* gore_mark = "gore";
/// There the verge begins: physical noses are 6 to 9 m wide between travelled ways, shoulders included (AASHTO, A
/// Policy on Geometric Design of Highways and Streets, 10.9.6).
inline constexpr double widest_gore_m = 5.0;
inline constexpr double longest_gore_m = 80.0;  ///< along the road
inline constexpr double gore_overlap_m = 0.3;   ///< of its lanes with the other road, so that one surface goes over

/// Of two one-way roads of class tertiary or above (links too, rings not) that lead out of a junction, or into it,
/// within 30 degrees of each other, from where their edges part to where they are widest_gore_m apart: both get a lane
/// of type "other" (written "restricted", OpenDRIVE 1.7, 11.7) that reaches over the other's edge, so that the surface
/// goes smoothly from the one road to the other; where the surfaces carried on meet with a step of over 2 cm, half of
/// the gap less the step instead, so that a bank lies between. The road of the lower class gets a road mark
/// "hatchedArea" named "gore" with the gore's outline: along its own edge, and back along the other road's, or its own
/// lane's where a bank follows. Gores less
/// than 0.8 m wide or less than 6 m long are none, nor is there one between roads more than 0.3 m apart in height,
/// beside a sidewalk or on a bridge or in a tunnel. Before junctions get their surfaces.
void add_gores(const NetworkPlan& plan, const std::vector<std::vector<JunctionEnd>>& ends, roadquery::RoadMap& map);

}  // namespace orthodrive::network
