// SPDX-License-Identifier: Apache-2.0
#pragma once
// Buildings of maps and photo: where they stand, how high, what they look like.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/building.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/buildings/building_style.hpp"
#include "orthodrive/scene/buildings/roof.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/roads/road_tint.hpp"

namespace orthodrive::scene {

/// What a building looks like.
struct PlacedBuilding {
  Vec2 middle;        ///< site CRS; footprint, roof and posts are relative to it
  Polygon footprint;  ///< simple, beside all roads and other buildings (of the same height, for parts)
  Roof roof;
  double foot_z_m = 0.0;   ///< where walls begin: below the lowest ground around, or where it hovers
  double base_z_m = 0.0;   ///< mean ground around: storeys count from here
  double eaves_z_m = 0.0;  ///< where walls end
  bool hovers = false;     ///< over its foot there is air: it has an underside
  int storeys = 1;
  BuildingLook look = BuildingLook::house;
  SurfaceMaterial wall_material = SurfaceMaterial::concrete;  ///< of walls without windows
  SurfaceMaterial roof_material = SurfaceMaterial::gravel;
  LinearColor wall_color{}, roof_color{};
  std::uint64_t seed = 0;       ///< of its variety: from its place
  std::size_t front = 0;        ///< the outer edge that looks at the nearest road
  double door_z_m = 0.0;        ///< the ground there
  double parapet_m = 0.0;       ///< of walls over a flat roof
  std::vector<double> eaves_m;  ///< how far the roof stands out over each outer edge; empty: nowhere
  std::vector<Vec2> posts;      ///< below roofs without walls
  std::optional<Vec3> chimney;  ///< its foot, site CRS
  std::string use, osm_id;      ///< as in Building
};

/// From the ground to the ridge.
[[nodiscard]] inline double height_m(const PlacedBuilding& building) {
  return building.eaves_z_m + building.roof.rise_m - building.base_z_m;
}

/// All is borrowed.
struct BuildingSite {
  std::span<const RoadLevel* const> levels;  ///< the ground first, then decks
  const Outline& area;
  const Ground& ground;
  const Photo& photo;
  int threads = 0;
};

/// Dresses buildings and puts them on the ground, in the order given.
/// - What a footprint has within 0.1 m of roads (decks of bridges count) and on buildings before it is cut off; a
///   building of which less than half is left is left out. Findings tell of cuts of 1 m2 and more:
///   "scene.building_on_road", "scene.building_overlap".
/// - Parts come before their outlines, the highest first, and stand on their ground: an outline of which parts leave
///   less than half is not drawn. What a part does not know it has from the outline in which its middle lies
///   ("scene.part_without_building": there is none). Parts and roofs on posts that begin 4.6 m above a road may
///   stand over it, and parts over each other where their heights do not overlap.
/// - Roofs of houses stand out by 0.4 m where no road and no other building is near.
/// Only buildings whose middle lies in the area count.
[[nodiscard]] std::vector<PlacedBuilding> place_buildings(std::span<const Building> buildings, const BuildingSite& site,
                                                          Findings& findings);

}  // namespace orthodrive::scene
