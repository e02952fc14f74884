#pragma once
// Flat shapes laid on a mesh: the mesh's own triangles carry them, so that they neither float nor sink.

#include <span>

#include "orthodrive/model/scene.hpp"

namespace orthodrive::scene {

/// Cuts convex counter-clockwise polygons (plan, in the frame of the mesh's positions) at the triangles from
/// `first_index` on and adds what lies over them to `target`, `lift_m` higher, with the mesh's normals and uv.
/// What lies over no triangle is left out.
void drape(const TriMesh& mesh, std::size_t first_index, std::span<const std::array<Vec2, 4>> polygons, double lift_m,
           TriMesh& target);

}  // namespace orthodrive::scene
