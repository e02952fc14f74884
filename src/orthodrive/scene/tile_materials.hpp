// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the meshes of a tile are drawn with besides the photo. Positions are relative to the tile's centre.

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/build_scene.hpp"
#include "orthodrive/scene/road_tint.hpp"
#include "orthodrive/scene/tile_features.hpp"

namespace orthodrive::scene {

[[nodiscard]] SurfaceMaterial material_of(roadquery::SurfaceClass surface);

/// Colour of a vertex for a tileable texture of that material; linear.
[[nodiscard]] std::array<std::uint16_t, 4> mesh_color(const LinearColor& color, double opacity = 1.0);

/// Collects triangles by their material.
class PartedTriangles {
 public:
  void add(SurfaceMaterial material, std::array<std::uint32_t, 3> triangle);
  /// Makes them the mesh's only triangles.
  void finish(TriMesh& mesh) const;

 private:
  std::array<std::vector<std::uint32_t>, surface_material_count> by_material_;
};

/// The terrain's triangles at the roads once more, opaque at the road and clear at the vertices beside it.
void add_verge(const SceneLayout& layout, const TriMesh& terrain, Vec2 center, TriMesh& verge);

/// Sorts the triangles by what the road is made of under their middle, and tints the vertices as the photo has it.
/// Asphalt of lanes for cars follows them, outside of junctions: across the lane from its left border to its right one,
/// along it by s.
void add_road_materials(const SceneLayout& layout, Vec2 center, const MeshLanes& lanes, TriMesh& road);

/// Water in the colour of its body.
void add_water_material(const SceneLayout& layout, Vec2 center, TriMesh& water);

/// One colour; textures lie flat on what looks up or down, and upright on sides.
void add_plain_material(SurfaceMaterial material, const LinearColor& color, TriMesh& mesh);

/// The same for a mesh that has its colours.
void add_material(SurfaceMaterial material, TriMesh& mesh);

}  // namespace orthodrive::scene
