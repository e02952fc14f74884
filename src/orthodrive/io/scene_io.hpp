#pragma once
// glTF and 3D Tiles 1.1 writing.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/model/scene.hpp"

namespace orthodrive::io {

/// What tileset.json needs of a tile once its glb is written.
struct TileEntry {
  std::string uri;
  Box2 bounds;  ///< site CRS
  double min_z_m = 0.0, max_z_m = 0.0;
};

/// One .glb: y up as glTF demands (3D Tiles turns it back), JPEG of the photo inside, a primitive a part of a mesh.
/// Tileable textures are named by material_file() and not inside. Labels become
/// feature ids with a table of their classes (EXT_mesh_features, EXT_structural_metadata).
/// Node translation = tile origin - site origin.
TileEntry write_tile_glb(const std::filesystem::path& folder, const SceneTile& tile, Vec3 site_origin);

/// Where write_material() puts a picture of a material ("color", "normal", "roughness"), relative to the folder.
[[nodiscard]] std::string material_file(SurfaceMaterial material, std::string_view picture);
void write_material(const std::filesystem::path& folder, SurfaceMaterial material, const SurfaceTexture& texture);

/// tileset.json: root transform from local east-north-up metres at `site_origin` to ECEF; asset.extras holds
/// {"orthodrive": {"crs", "origin": [x, y, z]}} so that a viewer can place what is given in the site CRS.
/// Tiles are sorted by uri: their order here does not matter.
void write_tileset(const std::filesystem::path& folder, const std::vector<TileEntry>& tiles, const Crs& crs,
                   Vec3 site_origin);

}  // namespace orthodrive::io
