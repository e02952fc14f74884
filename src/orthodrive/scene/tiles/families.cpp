// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/tiles/families.hpp"

#include <cstdint>

#include "orthodrive/scene/buildings/building_mesh.hpp"
#include "orthodrive/scene/look/mesh_materials.hpp"

namespace orthodrive::scene {
namespace {

class FaceFamily final : public Family {
 public:
  FaceFamily(const std::vector<StructureFace>& faces, std::vector<FaceMesh> meshes)
      : faces_(by_tile(faces)), meshes_(std::move(meshes)) {}
  void add_to(SceneTile& tile) const override {
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

 private:
  std::map<TileAddress, std::vector<StructureFace>> faces_;
  std::vector<FaceMesh> meshes_;
};

class BuildingFamily final : public Family {
 public:
  explicit BuildingFamily(const BuildingsByTile& buildings) : buildings_(buildings) {}
  void add_to(SceneTile& tile) const override {
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

 private:
  const BuildingsByTile& buildings_;
};

}  // namespace

void add_families(const Families& families, SceneTile& tile) {
  for (const std::unique_ptr<const Family>& family : families) family->add_to(tile);
}

std::unique_ptr<const Family> family_of_faces(const std::vector<StructureFace>& faces, std::vector<FaceMesh> meshes) {
  return std::make_unique<const FaceFamily>(faces, std::move(meshes));
}

std::unique_ptr<const Family> family_of_buildings(const BuildingsByTile& buildings) {
  return std::make_unique<const BuildingFamily>(buildings);
}

}  // namespace orthodrive::scene
