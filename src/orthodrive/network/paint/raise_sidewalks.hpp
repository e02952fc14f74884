// SPDX-License-Identifier: Apache-2.0
#pragma once
// Kerbs: how high sidewalks lie over the carriageway.

#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

inline constexpr double kerb_m = 0.12;          ///< RASt 06, 6.1.2: 12 cm in general
inline constexpr double lowered_kerb_m = 0.03;  ///< at crosswalks: DIN 18040-3
inline constexpr double kerb_ramp_m = 1.0;      ///< length of the stone that goes down

/// Gives the sidewalks of the map's roads heights (OpenDRIVE 1.7, 11.7.4): kerb_m, lowered_kerb_m beside crosswalks, 0
/// where a sidewalk ends (junctions, driveways, roads without one) and where another road's lanes or a junction lie on
/// it, with ramps of kerb_ramp_m. Both sides of a joint of two roads have the same height.
void raise_sidewalks(roadquery::RoadMap& map);

}  // namespace orthodrive::network
