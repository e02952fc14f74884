// SPDX-License-Identifier: Apache-2.0
#pragma once
// Buildings as meshes.

#include <cstdint>
#include <span>

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/buildings.hpp"

namespace orthodrive::scene {

enum class BuildingDetail : std::uint8_t {
  whole,   ///< with eaves, parapets, doors, gates and posts
  blocks,  ///< walls and roofs
};

/// All of them in one mesh; positions relative to `origin`, features are their places in the list.
[[nodiscard]] TriMesh building_mesh(std::span<const PlacedBuilding* const> buildings, Vec3 origin,
                                    BuildingDetail detail = BuildingDetail::whole);

/// Copies of one chimney on those that have one; none: no copies.
[[nodiscard]] InstancedMesh chimney_instances(std::span<const PlacedBuilding* const> buildings, Vec3 origin);

/// How far eaves, parapets and chimneys stand out of what blocks show, at most.
[[nodiscard]] double detail_reach_m(const PlacedBuilding& building);

}  // namespace orthodrive::scene
