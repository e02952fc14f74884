#pragma once
// Buildings as meshes: walls with storeys of windows, roofs in the photo's colour.

#include <map>
#include <span>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/building.hpp"
#include "orthodrive/model/scene.hpp"
#include "orthodrive/scene/ground.hpp"
#include "orthodrive/scene/road_tint.hpp"
#include "orthodrive/scene/roof.hpp"

namespace orthodrive::scene {

/// What a building looks like.
struct PlacedBuilding {
  Vec2 middle;        ///< site CRS; footprint and roof are relative to it
  Polygon footprint;  ///< simple, beside all roads and other buildings
  Roof roof;
  double foot_z_m = 0.0;   ///< where walls begin: below the lowest ground around
  double base_z_m = 0.0;   ///< mean ground around: storeys count from here
  double eaves_z_m = 0.0;  ///< where walls end
  int storeys = 1;
  bool windows = true;
  LinearColor wall_color{}, roof_color{};
  std::string use, osm_id;  ///< as in Building
};

/// From the ground to the ridge.
[[nodiscard]] inline double height_m(const PlacedBuilding& building) {
  return building.eaves_z_m + building.roof.rise_m - building.base_z_m;
}

/// Dresses buildings and puts them on the ground, in the order given. Heights, storeys and roofs come from the tags,
/// else from use and area: garages and sheds (and all below 60 m2) one storey of 2.6 m, houses up to 300 m2 two storeys
/// of 2.8 m and a gabled roof of 35 degrees, halls 8 m, others three storeys of 3 m, flat. What a footprint has within
/// 0.1 m of roads (decks of bridges count) and on buildings before it is cut off; a building of which less than half is
/// left is left out. Findings tell of cuts of 1 m2 and more: "scene.building_on_road", "scene.building_overlap". Only
/// buildings whose middle lies in the area count.
[[nodiscard]] std::vector<PlacedBuilding> place_buildings(std::span<const Building> buildings,
                                                          std::span<const RoadLevel* const> levels, const Outline& area,
                                                          const Ground& ground, const Photo& photo, int threads,
                                                          Findings& findings);

/// All of them in one mesh; positions relative to `origin`, features are their places in the list.
[[nodiscard]] TriMesh building_mesh(std::span<const PlacedBuilding* const> buildings, Vec3 origin);

}  // namespace orthodrive::scene
