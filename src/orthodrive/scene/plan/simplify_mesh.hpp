// SPDX-License-Identifier: Apache-2.0
#pragma once
// Fewer triangles for a mesh.

#include "orthodrive/model/scene.hpp"

namespace orthodrive::scene {

/// Joins triangles whose shape changes by at most the tolerance (meshoptimizer's quadrics), each material for itself,
/// and drops vertices that none is left with. Of vertices it keeps positions, normals, tile_uv and colours. Returns the
/// change in metres.
double simplify(TriMesh& mesh, double tolerance_m);

}  // namespace orthodrive::scene
