#pragma once
// What the scene stage makes of one tile.

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/class_table.hpp"

namespace orthodrive {

enum class MeshKind : std::uint8_t {
  terrain,
  road,       ///< carriageways, on the ground and on decks of bridges
  road_body,  ///< sides and undersides of bridge decks, facing outwards
};
/// The name in the glTF file: the viewer switches meshes by it.
[[nodiscard]] constexpr std::string_view to_string(MeshKind kind) {
  switch (kind) {
    case MeshKind::terrain:
      return "terrain";
    case MeshKind::road:
      return "road";
    case MeshKind::road_body:
      break;
  }
  return "road_body";
}

/// Triangles, counter-clockwise seen from above; x east, y north, z up, float metres relative to SceneTile::origin.
struct TriMesh {
  MeshKind kind = MeshKind::terrain;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  std::vector<std::array<float, 2>> uv;  ///< glTF: (0,0) is the north-west corner of the texture
  std::vector<std::uint32_t> indices;
};

struct SceneTile {
  int column = 0, row = 0;  ///< of the 480 m tile grid, row 0 in the south
  Vec3 origin;              ///< site CRS; also the frame of the positions
  double min_z_m = 0.0, max_z_m = 0.0;
  std::vector<TriMesh> meshes;
  Raster<std::uint8_t> texture_rgb;  ///< of the whole tile
  Raster<std::uint8_t> labels;       ///< of the whole tile: what the photo shows; empty: not known
  ClassTable classes;                ///< of the labels
};

}  // namespace orthodrive
