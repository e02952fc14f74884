// SPDX-License-Identifier: Apache-2.0
#pragma once
// Kerbs of race tracks.

#include "orthodrive/model/roads/road_material.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

inline constexpr double race_kerb_m = 1.2;         ///< wide
inline constexpr double race_kerb_rise_m = 0.05;   ///< at the outer border; the highest that Misano's kerbs (FIM) have
inline constexpr double race_kerb_taper_m = 3.0;   ///< over which one begins and ends
inline constexpr double race_bend_radius_m = 220;  ///< wider bends are driven flat out and have none
inline constexpr double exit_kerb_m = 30.0;        ///< beyond the bend's end

/// Borders with heights (written as lanes of type "curb") outside the carriageways of raceways outside junctions:
/// inclined from the carriageway's edge to race_kerb_rise_m at their outer border, of concrete. By the curvature, as
/// its mean over 40 m:
/// - on the inner side of a bend where it is at least half the bend's largest, and at least 1 / race_bend_radius_m;
/// - on the outer side from there on to exit_kerb_m beyond the bend, in every direction in which one drives.
/// Roads that are linked without a junction are one track. Where another carriageway or a junction lies there, there is
/// none. Before junctions get their surfaces: where they begin no kerb has a width.
void add_race_kerbs(roadquery::RoadMap& map, Weather weather);

}  // namespace orthodrive::network
