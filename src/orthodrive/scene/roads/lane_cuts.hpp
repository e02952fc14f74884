// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the mesh of a road is cut so that each of its triangles belongs to one lane.

#include <vector>

#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/scene/roads/road_joints.hpp"
#include "orthodrive/scene/roads/road_strip.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::scene {

/// Lines along the borders between the lanes of a road, and across it at its ends and where its lanes change; on the
/// plan grid. None of connecting roads: a junction has one surface. `strip`: the road's sections as its level has them.
/// At joints lines end in the joint's points.
[[nodiscard]] std::vector<Polyline> lane_cuts(const roadquery::Road& road, const std::vector<CrossSection>& strip,
                                              const EndPoints& joints);

/// t of the borders between the lanes of a road at an end, from right to left, without the outer edges.
[[nodiscard]] std::vector<double> lane_borders_at(const roadquery::Road& road, bool at_end);

}  // namespace orthodrive::scene
