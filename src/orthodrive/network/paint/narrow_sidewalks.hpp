// SPDX-License-Identifier: Apache-2.0
#pragma once
// Sidewalks leave the carriageways of other roads to them.

#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

/// Beside an acute fork and between roads that run side by side a sidewalk of full width would lie on another road's
/// lanes, on the plane of its own road: both would be the surface there. Each sidewalk becomes as narrow as what is
/// free beside its road, 0 where nothing is; its outer border moves by 0.5 m a metre at most. Both sides of a joint of
/// two roads have the same width. Before junctions get their surfaces, which leave sidewalks out.
void narrow_sidewalks(roadquery::RoadMap& map);

}  // namespace orthodrive::network
