// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a layout has placed of one kind.

#include <algorithm>
#include <vector>

#include "orthodrive/scene/tiles/scene_layout.hpp"

namespace orthodrive::scene {

/// Empty where the layout has no family of it.
template <typename Placed>
const std::vector<Placed>& placed(const SceneLayout& layout) {
  for (const auto& family : layout.families)
    if (const auto* of_kind = dynamic_cast<const CopiedFamily<Placed>*>(family.get())) return of_kind->placed();
  static const std::vector<Placed> none;
  return none;
}

/// The faces of the family that makes meshes of that kind; likewise.
inline const FacesByTile& placed_faces(const SceneLayout& layout, MeshKind kind) {
  for (const auto& family : layout.families)
    if (const auto* of_faces = dynamic_cast<const FaceFamily*>(family.get()))
      if (std::ranges::find(of_faces->meshes(), kind, &FaceMesh::kind) != of_faces->meshes().end())
        return of_faces->faces();
  static const FacesByTile none;
  return none;
}

}  // namespace orthodrive::scene
