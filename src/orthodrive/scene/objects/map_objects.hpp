// SPDX-License-Identifier: Apache-2.0
#pragma once
// What maps have at points: signs, traffic lights, street furniture, towers; and power lines.

#include <span>
#include <vector>

#include "orthodrive/model/map_surroundings.hpp"
#include "orthodrive/scene/buildings/free_space.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/structures/structures.hpp"

namespace orthodrive::scene {

/// All is borrowed.
struct ObjectPlaces {
  const RoadLevel& roads;  ///< on the ground
  const roadquery::RoadQuery& query;
  const FreeSpace& space;
  const Ground& ground;
  std::span<const std::vector<double>> power_ground_m;  ///< terrain at the points of each power line
};

struct ObjectFaces {
  std::vector<StructureFace> small;  ///< signs, furniture, poles, wires: nothing of them shows from afar
  std::vector<StructureFace> large;  ///< towers, chimneys, tanks
};

/// Nothing stands on a road, a deck, in a building or an opening: the disc around an object is free. Signs and traffic
/// lights that lie on a road in the map come beside it, on the right of a driver towards the nearer end of the road
/// (left where one drives on the left), traffic lights for both directions, those of a junction at its arms; they look
/// at who comes. Other objects on a road are left out. What stands beside a road looks at it.
/// Wires hang in catenaries (sag 2.5 % of the span) between the points of their line: three at 20 m, of minor lines
/// at 8.6 m over the ground.
[[nodiscard]] ObjectFaces object_faces(const MapSurroundings& surroundings, const ObjectPlaces& places);

}  // namespace orthodrive::scene
