// SPDX-License-Identifier: Apache-2.0
#pragma once
// Flat shapes laid on a mesh: the mesh's own triangles carry them, so that they neither float nor sink.

#include <functional>
#include <span>

#include "orthodrive/model/scene.hpp"

namespace orthodrive::scene {

/// A corner of a polygon laid on a mesh, with the mesh's height and unit normal there.
struct DrapedCorner {
  Vec2 p;
  double z = 0.0;
  std::array<double, 3> normal{};
};

/// Cuts convex counter-clockwise polygons (plan, in the frame of the mesh's positions) at the triangles from
/// `first_index` on. `use` gets each part, counter-clockwise, with the index of its polygon.
void cut_at_mesh(const TriMesh& mesh, std::size_t first_index, std::span<const std::array<Vec2, 4>> polygons,
                 const std::function<void(std::size_t, std::span<const DrapedCorner>)>& use);

/// Cuts convex counter-clockwise polygons (plan, in the frame of the mesh's positions) at the triangles from
/// `first_index` on and adds what lies over them to `target`, `lift_m` higher, with the mesh's normals.
/// What lies over no triangle is left out.
void drape(const TriMesh& mesh, std::size_t first_index, std::span<const std::array<Vec2, 4>> polygons, double lift_m,
           TriMesh& target);

}  // namespace orthodrive::scene
