// SPDX-License-Identifier: Apache-2.0
#pragma once
// What stands at roads and carries them: edge beams, railings, girders and piers of bridges, guard rails.

#include <array>
#include <map>
#include <span>
#include <vector>

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"
#include "orthodrive/scene/roads/road_level.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"

namespace orthodrive::scene {

/// A flat face, counter-clockwise from outside; site CRS.
struct StructureFace {
  std::array<Vec3, 4> corners;
  LinearColor color{};
  SurfaceMaterial material = SurfaceMaterial::concrete;
  bool is_rail = false;  ///< of railings and guard rails: thinner than a decimetre
};

/// Of railings over the road: what a silhouette loses without them.
constexpr double railing_height_m = 1.15;

struct StructureInput {
  const RoadLevel& roads;  ///< on the ground
  std::span<const RoadLevel> decks;
  const Ground& ground;
  const roadquery::RoadQuery& query;
  double deck_thickness_m = 0.8;
};

/// Along the sides of decks: an edge beam of concrete 0.5 m wide outside of the deck, 0.15 m higher than it, and on it
/// a railing of 1 m. Where the ground falls away below a deck's end by 0.3 m: an abutment, a wall across from the deck
/// into the ground, and walls from there along both sides to the deck's end. Below decks that are 2.5 m and more above
/// the ground: two girders a road, and walls as piers at most 25 m apart, on the ground and on no road. Beside
/// motorways and trunk roads on the ground: a guard rail, 0.75 m high and 0.75 m beside the edge (RPS 2009). Around
/// islands, inside holes of the carriageways on the ground: a kerb stone of 0.15 m, 0.12 m over the road; islands are
/// holes up to 150 m2, and up to 3000 m2 those that all lanes beside them circle. Nothing stands where another road
/// runs. The same for every tile.
[[nodiscard]] std::vector<StructureFace> build_structures(const StructureInput& input);

/// By their first corners; those with the same one keep their order.
void sort_by_place(std::vector<StructureFace>& faces);

/// Faces by the tile of their middle.
[[nodiscard]] std::map<TileAddress, std::vector<StructureFace>> by_tile(std::span<const StructureFace> faces);

/// Which faces go into a mesh.
struct FaceFilter {
  SurfaceMaterial material = SurfaceMaterial::concrete;
  bool is_rail = false;
};
/// Adds such faces to a mesh whose positions are relative to `origin`.
void add_faces(std::span<const StructureFace> faces, const FaceFilter& filter, Vec3 origin, TriMesh& mesh);

}  // namespace orthodrive::scene
