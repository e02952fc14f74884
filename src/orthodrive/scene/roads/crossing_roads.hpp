// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads that one OSM layer holds but that lie over each other.

#include <span>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::scene {

/// Roads of one layer in as few sets as keep those apart that cross in plan with more than 1.5 m between them (what
/// roadquery/blend.hpp takes for two surfaces). Roads that run on into each other or share a junction stay together
/// unless they cross themselves so. Roads and sets are in the order given, and never empty.
[[nodiscard]] std::vector<std::vector<const roadquery::Road*>> told_apart(
    std::span<const roadquery::Road* const> roads);

/// Of roads on the ground those that somewhere lie more than 1.5 m over another one, one flag a road: a map may lack a
/// bridge, and on a slope roads stand closer than they are wide. Not roads of junctions, which share a surface.
[[nodiscard]] std::vector<bool> lying_over(std::span<const roadquery::Road> roads);

/// Where the scene has a road: cut into the ground, on a bridge over it, or in a tube below it. `lies_over`: its flag
/// of lying_over().
enum class RoadStructure { ground, deck, tunnel };
[[nodiscard]] RoadStructure structure_of(const roadquery::Road& road, bool lies_over);

}  // namespace orthodrive::scene
