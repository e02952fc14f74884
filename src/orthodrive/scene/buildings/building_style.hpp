// SPDX-License-Identifier: Apache-2.0
#pragma once
// What tags, use and size say of a building before it stands anywhere.

#include <cstdint>

#include "orthodrive/model/building.hpp"
#include "orthodrive/scene/buildings/roof.hpp"

namespace orthodrive::scene {

/// What the walls show.
enum class BuildingLook : std::uint8_t {
  plain,   ///< sheds, bunkers, what hovers: plaster
  house,   ///< framed windows, a door
  flats,   ///< rows of windows with balconies along the long walls, a glazed door
  hall,    ///< sheet metal, a ribbon of windows below the eaves, gates
  shop,    ///< windows over a glazed ground floor
  garage,  ///< gates side by side
  church,  ///< tall windows
};

struct BuildingStyle {
  double height_m = 0.0;  ///< ground to eaves, or to the ridge where `with_roof`
  bool with_roof = false;
  int storeys = 1;  ///< 0: as many as fit below the eaves
  BuildingLook look = BuildingLook::house;
  RoofWish roof;
};

/// Heights, storeys and roofs come from the tags, else from use and area (m2): garages and sheds (and all below 60 m2)
/// one storey of 2.6 m, houses up to 300 m2 two storeys of 2.8 m and a gabled roof of 35 degrees, halls 8 m, churches
/// 10 m and 50 degrees, others three storeys of 3 m, flat. A storey of levels is 3 m high, of roof:levels likewise.
[[nodiscard]] BuildingStyle style_of(const Building& building, double area_m2);

/// The height of the whole building over the ground, without a roof that stands on top of the storeys.
[[nodiscard]] inline double top_m(const BuildingStyle& style) {
  return style.height_m + (style.with_roof ? 0.0 : style.roof.rise_m);
}

}  // namespace orthodrive::scene
