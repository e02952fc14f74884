// SPDX-License-Identifier: Apache-2.0
#pragma once
// What maps know of the ground's surface: car parks with their bays, paths and pavements, gravel traps. Laid over the
// photo.

#include <array>
#include <span>
#include <vector>

#include "orthodrive/model/map_surroundings.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/free_space.hpp"
#include "orthodrive/scene/ground/water.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"

namespace orthodrive::scene {

/// Flat pieces in plan, counter-clockwise, to be laid on the terrain; site CRS.
struct PlacedCover {
  Vec2 middle;  ///< of the square of 96 m that all of it lies in
  SurfaceMaterial material = SurfaceMaterial::asphalt;
  double lift_m = 0.0;                     ///< over the terrain
  std::vector<std::array<Vec2, 4>> faces;  ///< triangles: the last corner twice
  std::vector<std::array<Vec2, 4>> lines;  ///< between bays
  LinearColor color{};
};

/// All is borrowed.
struct CoverSite {
  const FreeSpace& space;
  const Waters& waters;
  const Photo& photo;
  const LabelMap* labels;  ///< none: nullptr
  Box2 box;                ///< squares whose middle lies elsewhere are left out
  int threads = 0;
};

/// Car parks, paths and gravel, in this order: what those before leave of each, in squares of 96 m whose middle lies in
/// the scene's area. Roads and water cut them off because no terrain lies there. Bays of 2.5 x 5 m lie along the longer
/// side of the narrowest rectangle around a car park, in rows with aisles of 6 m between them (FGSV, EAR 05); a line is
/// drawn where all of it lies on the car park, beside roads, buildings and water. The colour is the photo's median,
/// without what its labels call vegetation.
[[nodiscard]] std::vector<PlacedCover> place_covers(const MapSurroundings& surroundings, const CoverSite& site);

/// Meshes of a tile: one for each material, laid on the terrain's triangles. Lines between bays are added to the
/// marking. Positions of all meshes are relative to `center` in plan.
[[nodiscard]] std::vector<TriMesh> cover_meshes(const TriMesh& terrain, std::span<const PlacedCover* const> covers,
                                                Vec2 center, TriMesh& marking);

}  // namespace orthodrive::scene
