// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/families.hpp"

#include <cstdint>

#include "orthodrive/scene/buildings/building_mesh.hpp"
#include "orthodrive/scene/look/mesh_materials.hpp"

namespace orthodrive::scene {

void FaceFamily::add_to(SceneTile& tile) const {
  const auto found = faces_.find({tile.column, tile.row});
  if (found == faces_.end()) return;
  for (const FaceMesh& of : meshes_) {
    TriMesh mesh{.kind = of.kind};
    add_faces(found->second, of.faces, tile.origin, mesh);
    if (mesh.indices.empty()) continue;
    add_material(of.faces.material, mesh);
    tile.meshes.push_back(std::move(mesh));
  }
}

void BuildingFamily::add_to(SceneTile& tile) const {
  const auto found = buildings_.find({tile.column, tile.row});
  if (found == buildings_.end()) return;
  TriMesh mesh = building_mesh(found->second, tile.origin);
  for (std::uint32_t& feature : mesh.features) feature += static_cast<std::uint32_t>(tile.features.size());
  for (const PlacedBuilding* building : found->second)
    tile.features.push_back({.kind = "building", .osm_id = building->osm_id, .type = building->use});
  if (!mesh.indices.empty()) tile.meshes.push_back(std::move(mesh));
  InstancedMesh chimneys = chimney_instances(found->second, tile.origin);
  if (!chimneys.instances.empty()) tile.instanced.push_back(std::move(chimneys));
}

}  // namespace orthodrive::scene
