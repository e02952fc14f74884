#pragma once
// Gravel traps and other ground of gravel or sand that maps know.

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/scene_layout.hpp"

namespace orthodrive::scene {

/// The parts of the terrain's triangles that lie in the surroundings' gravel once more, a centimetre higher, of gravel
/// in the photo's colour. Positions are relative to the tile's centre, as the terrain's.
void add_gravel(const SceneLayout& layout, const TriMesh& terrain, Vec2 center, TriMesh& gravel);

}  // namespace orthodrive::scene
