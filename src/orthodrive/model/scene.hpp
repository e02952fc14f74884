// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the scene stage makes of one tile.

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive {

enum class MeshKind : std::uint8_t {
  terrain,
  road,         ///< carriageways, on the ground and on decks of bridges
  road_body,    ///< sides and undersides of bridge decks, facing outwards
  verge,        ///< the ground beside roads once more: covers it where roads begin and fades away from them
  marking,      ///< paint, a few millimetres over the road
  kerb,         ///< lanes that lie higher than the road, and their faces
  structure,    ///< piers, girders, abutments and edge beams of bridges
  rails,        ///< railings of bridges, guard rails
  building,     ///< walls and roofs
  tree,         ///< copies of a few shapes
  water,        ///< lakes and rivers, each at one level; meets the terrain as roads do
  barrier,      ///< hedges, walls, fences
  track,        ///< railways: ballast and rails
  lamp,         ///< copies: street lamps
  object,       ///< signs, traffic lights, street furniture, poles and wires
  tunnel,       ///< tubes of tunnels, their portals and walls
  tunnel_road,  ///< roads in tunnels and between the walls before them
};
constexpr std::size_t mesh_kind_count = static_cast<std::size_t>(MeshKind::tunnel_road) + 1;
/// The name in the glTF file: the viewer switches meshes by it.
[[nodiscard]] constexpr std::string_view to_string(MeshKind kind) {
  switch (kind) {
    case MeshKind::terrain:
      return "terrain";
    case MeshKind::road:
      return "road";
    case MeshKind::road_body:
      return "road_body";
    case MeshKind::verge:
      return "verge";
    case MeshKind::marking:
      return "marking";
    case MeshKind::kerb:
      return "road_kerb";
    case MeshKind::structure:
      return "road_structure";
    case MeshKind::rails:
      return "road_rails";
    case MeshKind::building:
      return "building";
    case MeshKind::water:
      return "water";
    case MeshKind::barrier:
      return "barrier";
    case MeshKind::track:
      return "track";
    case MeshKind::lamp:
      return "lamp";
    case MeshKind::object:
      return "object";
    case MeshKind::tunnel:
      return "road_tube";
    case MeshKind::tunnel_road:
      return "road_in_tunnel";
    case MeshKind::tree:
      break;
  }
  return "tree";
}

/// What a surface is drawn with: the tile's photo, or a tileable texture tinted by the mesh's colours.
enum class SurfaceMaterial : std::uint8_t {
  photo,
  asphalt,
  concrete,
  setts,
  gravel,
  ground,
  verge,
  paint,
  facade,      ///< plaster with four storeys of four windows
  roof_tiles,  ///< rows along the eaves
  foliage,     ///< leaves and needles
  water,       ///< low waves
  balconies,   ///< of flats: as facade, with balconies
  cladding,    ///< sheet metal, boards
  openings,    ///< doors, gates, shop windows: places in scene/look/facade_picture
  lane,        ///< asphalt that follows a lane, from its left border to its right one
  leaves,      ///< trees: bark, and clusters of leaves with holes; places in scene/look/leaf_picture
};
constexpr std::size_t surface_material_count = 17;
/// The name of the glTF material and of its pictures.
[[nodiscard]] constexpr std::string_view to_string(SurfaceMaterial material) {
  constexpr std::array<std::string_view, surface_material_count> names = {
      "photo",      "asphalt", "concrete", "setts",     "gravel",   "ground",   "verge",        "paint", "facade",
      "roof_tiles", "foliage", "water",    "balconies", "cladding", "openings", "asphalt_lane", "leaves"};
  return names[static_cast<std::size_t>(material)];
}

/// Triangles of a mesh that have one material.
struct MeshPart {
  SurfaceMaterial material = SurfaceMaterial::photo;
  std::size_t first_index = 0, index_count = 0;  ///< into TriMesh::indices
};

/// Triangles, counter-clockwise seen from above; x east, y north, z up, float metres relative to SceneTile::origin.
struct TriMesh {
  MeshKind kind = MeshKind::terrain;
  std::vector<std::array<float, 3>> positions;
  std::vector<std::array<float, 3>> normals;
  /// glTF: (0,0) is the north-west corner of the photo. Empty where no triangle shows it: of buildings and trees.
  std::vector<std::array<float, 2>> uv;
  std::vector<std::uint32_t> indices;
  std::vector<MeshPart> parts;  ///< in the order of their materials, all triangles; empty: all show the photo
  /// One a vertex, or empty where all show the photo: place in tileable textures, in their sides.
  std::vector<std::array<float, 2>> tile_uv;
  /// One a vertex, or empty. Linear red, green and blue that a tileable texture is multiplied by, and opacity;
  /// 65535: 1.
  std::vector<std::array<std::uint16_t, 4>> colors;
  std::vector<std::uint32_t> features;  ///< one per vertex, or empty: index into SceneTile::features, or no_feature
};
constexpr std::uint32_t no_feature = std::numeric_limits<std::uint32_t>::max();

/// A lane of a road or a building, for those who click on it.
struct SceneFeature {
  std::string kind;    ///< "road" or "building"
  std::string id;      ///< of the OpenDRIVE road; empty: none
  std::string osm_id;  ///< "way/123", "relation/45"; empty: not of OSM
  std::string name;
  std::string type;       ///< OSM's highway=* or building=*
  std::string lane_id;    ///< of the OpenDRIVE lane; empty: no lane
  std::string lane_type;  ///< as OpenDRIVE names it
};

/// A copy of a mesh: stretched, turned about z, then moved.
struct MeshInstance {
  std::array<float, 3> position{};  ///< x east, y north, z up, relative to SceneTile::origin
  float yaw_rad = 0.0F;             ///< counter-clockwise from above
  std::array<float, 3> scale = {1.0F, 1.0F, 1.0F};
  std::array<float, 3> tint = {1.0F, 1.0F, 1.0F};  ///< factor of the mesh's colours
};
struct InstancedMesh {
  TriMesh mesh;  ///< at most 1 from its own axis before it is stretched
  std::vector<MeshInstance> instances;
};

/// Pictures of a material, all of one size, tileable but for those that have places: x to the east, rows from the
/// north. Leaves have their colour alone.
struct SurfaceTexture {
  Raster<std::uint8_t> color;       ///< sRGB; of leaves with opacity, 0 or 255, as fourth channel
  Raster<std::uint8_t> normal_rgb;  ///< glTF: 0.5 (n + 1) of the unit normal, y to the north
  Raster<std::uint8_t> roughness;   ///< 3 channels as glTF wants them: roughness in the green one, blue (metal) is 0
};

struct SceneTile {
  int level = 0;            ///< of detail: 0 has all, a tile of level k is 480 m * 2^k wide
  int column = 0, row = 0;  ///< of the level's grid of tiles, row 0 in the south
  Vec3 origin;              ///< site CRS; also the frame of the positions
  double min_z_m = 0.0, max_z_m = 0.0;
  double geometric_error_m = 0.0;  ///< what is lost to level 0: heights, silhouettes, texels
  std::vector<TriMesh> meshes;
  /// The ground over openings for tunnels, with the terrain's vertices around them: not in the file of level 0, part of
  /// the terrain in coarser tiles.
  TriMesh lids;
  std::vector<InstancedMesh> instanced;
  Raster<std::uint8_t> texture_rgb;  ///< of the whole tile
  Raster<std::uint8_t> labels;       ///< of the whole tile: what the photo shows; empty: not known
  ClassTable classes;                ///< of the labels
  std::vector<SceneFeature> features;
};

}  // namespace orthodrive
