// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tiles as scene_io.hpp writes them, read back: to score what a viewer gets.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/model/scene.hpp"

namespace orthodrive::io {

/// A tile of a tileset.json.
struct TileFile {
  std::filesystem::path path;
  int level = 0, column = 0, row = 0;
  Vec3 origin;  ///< site CRS
  double geometric_error_m = 0.0;
  std::uintmax_t bytes = 0;
};

/// All tiles of all levels, parents first. Throws InputError for a tileset that is not ours.
[[nodiscard]] std::vector<TileFile> read_tileset(const std::filesystem::path& folder);

/// Meshes and copies: kinds, positions, normals, first set of coordinates and indices alone; and the photo. Throws
/// InputError for a file that is broken.
[[nodiscard]] SceneTile read_tile_glb(const TileFile& file);

}  // namespace orthodrive::io
