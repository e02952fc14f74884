// SPDX-License-Identifier: Apache-2.0
#pragma once
// The lanes of all roads as strips of triangles on the surface that is driven, for pages to draw.

#include <array>
#include <vector>

#include "roadquery/query/road_query.hpp"

/// One strip after the other: the lane's type (roadquery::LaneType), its road's junction (-1: none), how many pairs of
/// places follow, then x, y, z of the inner and the outer border of each, less the origin; m.
[[nodiscard]] std::vector<float> lane_strips(const roadquery::RoadQuery& roads, const std::array<double, 3>& origin_m);
