// SPDX-License-Identifier: Apache-2.0
#pragma once
// What verges, roads and water of a tile are drawn with besides the photo. Positions are relative to the tile's centre.

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/tiles/scene_layout.hpp"
#include "orthodrive/scene/tiles/tile_features.hpp"

namespace orthodrive::scene {

/// The terrain's triangles at the roads once more, opaque at the road and clear at the vertices beside it.
void add_verge(const SceneLayout& layout, const TriMesh& terrain, Vec2 center, TriMesh& verge);

/// Sorts the triangles by what the road is made of under their middle, and tints the vertices as the photo has it.
/// Asphalt of lanes for cars follows them, outside of junctions: across the lane from its left border to its right one,
/// along it by s.
void add_road_materials(const SceneLayout& layout, Vec2 center, const MeshLanes& lanes, TriMesh& road);

/// Water in the colour of its body.
void add_water_material(const SceneLayout& layout, Vec2 center, TriMesh& water);

}  // namespace orthodrive::scene
