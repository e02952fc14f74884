// SPDX-License-Identifier: Apache-2.0
#pragma once
// The middle of a mini-roundabout: paved, with a white disc.

#include <map>
#include <span>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/network/topology/mini_roundabouts.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

inline constexpr const char* mini_roundabout_mark = "mini-roundabout";

/// A road mark a quarter as wide as the disc, 1 to 4 m (DMRB TD 54/07, 1.1), in its middle: an
/// object of the road whose line runs round it nearest.
void add_mini_roundabout_marks(std::span<const MiniRoundaboutDisc> discs, roadquery::RoadMap& map);

/// The middles of the discs, which their lanes go round: each by the junction of the ring that comes first.
[[nodiscard]] std::map<int, Polygon> paved_middles(std::span<const MiniRoundaboutDisc> discs,
                                                   const roadquery::RoadMap& map);

}  // namespace orthodrive::network
