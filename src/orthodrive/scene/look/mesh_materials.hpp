// SPDX-License-Identifier: Apache-2.0
#pragma once
// What meshes are drawn with besides the photo: tileable textures, tinted vertex by vertex.

#include <array>
#include <cstdint>
#include <vector>

#include "orthodrive/model/rasters/srgb.hpp"
#include "orthodrive/model/scene.hpp"
#include "roadquery/map/surface_class.hpp"

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

/// Adds texture coordinates of a vertex whose place and normal are there. Textures lie flat on what looks up or down,
/// upright on sides.
void add_tile_place(std::size_t vertex, TriMesh& mesh);

/// One colour; textures lie flat on what looks up or down, and upright on sides.
void add_plain_material(SurfaceMaterial material, const LinearColor& color, TriMesh& mesh);

/// The same for a mesh that has its colours.
void add_material(SurfaceMaterial material, TriMesh& mesh);

}  // namespace orthodrive::scene
