// SPDX-License-Identifier: Apache-2.0
#pragma once
// glTF 2.0 of the scene's tiles (3D Tiles 1.1; the tree of them is in tileset_io.hpp).

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "orthodrive/io/tiles/tileset_io.hpp"
#include "orthodrive/model/scene.hpp"

namespace orthodrive::io {

enum class PhotoFormat : std::uint8_t { jpeg, webp };

struct TileFileOptions {
  bool compressed = true;  ///< by meshoptimizer (EXT_meshopt_compression); plain floats otherwise
  PhotoFormat photo = PhotoFormat::jpeg;
};

/// One .glb: y up as glTF demands (3D Tiles turns it back), the photo inside, a primitive a part of a mesh. Positions
/// count from the middle of the tile at a height of the tile in whole metres (TileEntry::origin). Compressed, they are
/// multiples of 1/1024 m, and equal ones of neighbours stay equal.
/// Tileable textures are named by material_file() and not inside. Labels become
/// feature ids with a table of their classes (EXT_mesh_features, EXT_structural_metadata).
TileEntry write_tile_glb(const std::filesystem::path& folder, const SceneTile& tile,
                         const TileFileOptions& options = {});

/// Tiles of level 0 in one .glb for programs that are no viewers (Blender, game engines): plain floats, all pictures
/// inside, materials lit, a node "tile_<column>_<row>" for each tile with its meshes, each tree a node of its own.
/// Positions count from `origin`, y up.
void write_area_glb(const std::filesystem::path& file, std::span<const SceneTile> tiles, Vec3 origin,
                    const std::function<SurfaceTexture(SurfaceMaterial)>& texture_of);

/// Where write_material() puts a picture of a material ("color", "normal", "roughness"), relative to the folder.
[[nodiscard]] std::string material_file(SurfaceMaterial material, std::string_view picture);
/// The bytes of these pictures, in that order; of leaves the colour alone.
using MaterialPictures = std::vector<std::string>;
[[nodiscard]] MaterialPictures encode_material(SurfaceMaterial material, const SurfaceTexture& texture);
void write_material(const std::filesystem::path& folder, SurfaceMaterial material, const MaterialPictures& pictures);

}  // namespace orthodrive::io
