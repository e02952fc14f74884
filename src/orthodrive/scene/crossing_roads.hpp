#pragma once
// Roads that one OSM layer holds but that cross each other at different heights.

#include <span>
#include <vector>

#include "roadquery/road_map.hpp"

namespace orthodrive::scene {

/// Roads of one layer in as few sets as keep those apart that cross in plan with more than 1.5 m between them (what
/// roadquery/blend.hpp takes for two surfaces). Roads that run on into each other or share a junction stay together
/// unless they cross themselves so. Roads and sets are in the order given, and never empty.
[[nodiscard]] std::vector<std::vector<const roadquery::Road*>> told_apart(
    std::span<const roadquery::Road* const> roads);

}  // namespace orthodrive::scene
