// SPDX-License-Identifier: Apache-2.0
#pragma once
// What stands on the ground and the roads, kind by kind. A new kind of thing is a file that places it and a line in
// scene_layout.cpp that makes a family of it; tiles ask every family in the same way.

#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/buildings.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"
#include "orthodrive/scene/structures/structures.hpp"

namespace orthodrive::scene {

/// Things of one kind in a block of tiles.
class Family {
 public:
  virtual ~Family() = default;
  /// Adds what of them stands in the tile to its meshes, copies and features. Safe from any thread.
  virtual void add_to(SceneTile& tile) const = 0;
};
using Families = std::vector<std::unique_ptr<const Family>>;

/// One of the meshes that a family's faces make.
struct FaceMesh {
  MeshKind kind;
  FaceFilter faces;  ///< those that it takes; its material is theirs
};
using FacesByTile = std::map<TileAddress, std::vector<StructureFace>>;
/// Faces, each in the tile of its middle.
class FaceFamily final : public Family {
 public:
  FaceFamily(const std::vector<StructureFace>& faces, std::vector<FaceMesh> meshes)
      : faces_(by_tile(faces)), meshes_(std::move(meshes)) {}
  void add_to(SceneTile& tile) const override;
  [[nodiscard]] const FacesByTile& faces() const { return faces_; }
  [[nodiscard]] const std::vector<FaceMesh>& meshes() const { return meshes_; }

 private:
  FacesByTile faces_;
  std::vector<FaceMesh> meshes_;
};

using BuildingsByTile = std::map<TileAddress, std::vector<const PlacedBuilding*>>;
class BuildingFamily final : public Family {
 public:
  /// `buildings` and what they point to outlive it.
  explicit BuildingFamily(const BuildingsByTile& buildings) : buildings_(buildings) {}
  void add_to(SceneTile& tile) const override;

 private:
  const BuildingsByTile& buildings_;
};

/// Copies of few shapes. `foot`: where one stands in the plan; `copies`: those of a tile, relative to its origin.
template <typename Placed>
class CopiedFamily final : public Family {
 public:
  using Of = std::vector<const Placed*>;
  using Copies = std::function<std::vector<InstancedMesh>(const Of& placed, Vec3 origin)>;

  CopiedFamily(std::vector<Placed> placed, const std::function<Vec2(const Placed&)>& foot, Copies copies)
      : placed_(std::move(placed)), copies_(std::move(copies)) {
    for (const Placed& one : placed_) in_tile_[tile_at(foot(one))].push_back(&one);
  }
  void add_to(SceneTile& tile) const override {
    const auto found = in_tile_.find({tile.column, tile.row});
    if (found == in_tile_.end()) return;
    for (InstancedMesh& copied : copies_(found->second, tile.origin)) tile.instanced.push_back(std::move(copied));
  }

  [[nodiscard]] const std::vector<Placed>& placed() const { return placed_; }

 private:
  std::vector<Placed> placed_;
  std::map<TileAddress, Of> in_tile_;
  Copies copies_;
};

}  // namespace orthodrive::scene
