#pragma once
// Car parks: asphalt over the photo, bays painted on it.

#include <array>
#include <span>
#include <vector>

#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings.hpp"
#include "orthodrive/scene/water.hpp"

namespace orthodrive::scene {

/// Flat pieces in plan, counter-clockwise, to be laid on the terrain; site CRS.
struct PlacedParking {
  Vec2 middle;                               ///< of the square of 96 m that all of it lies in
  std::vector<std::array<Vec2, 4>> asphalt;  ///< triangles: the last corner twice
  std::vector<std::array<Vec2, 4>> lines;    ///< between bays
  LinearColor color{};
};

/// All is borrowed.
struct ParkingSite {
  std::span<const RoadLevel* const> levels;
  std::span<const PlacedBuilding> buildings;
  const Waters& waters;
  const Outline& area;
  const Photo& photo;
  int threads = 0;
};

/// What roads, buildings and water leave of the areas, in squares of 96 m whose middle lies in the scene's area. Bays
/// of 2.5 x 5 m lie along the longer side of the narrowest rectangle around an area, in rows with aisles of 6 m between
/// them (FGSV, EAR 05); a line is drawn where all of it lies on the asphalt. The colour is the photo's median.
[[nodiscard]] std::vector<PlacedParking> place_parking(const MultiPolygon& areas, const ParkingSite& site);

/// Lays the asphalt on the terrain's triangles, a little higher, and lines a little higher still. Positions of all
/// meshes are relative to `center` in plan.
void add_parking(const TriMesh& terrain, std::span<const PlacedParking* const> parking, Vec2 center, TriMesh& asphalt,
                 TriMesh& marking);

}  // namespace orthodrive::scene
