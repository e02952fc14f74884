// SPDX-License-Identifier: Apache-2.0
#pragma once
// What runs along lines of maps: hedges, walls, fences, guard rails, railways; and street lamps.

#include <vector>

#include "orthodrive/model/map_surroundings.hpp"
#include "orthodrive/scene/buildings/free_space.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/structures/structures.hpp"

namespace orthodrive::scene {

/// Barriers stand 0.1 m beside roads, decks and buildings, on the ground: hedges 0.8 m wide and 1.3 m high, walls 0.3 m
/// and 1.6 m, fences 0.06 m and 1.2 m, guard rails; a height of the map counts. What of a line has no room is left out,
/// to a quarter of a metre. Pieces of at most 4 m follow the ground.
[[nodiscard]] std::vector<StructureFace> barrier_faces(std::span<const MapBarrier> barriers, const FreeSpace& space,
                                                       const Ground& ground);

/// Ballast 2.6 m wide on top, 0.3 m over the ground, and two rails 1.435 m apart; pieces of at most 6 m. None on roads,
/// under decks with less than 5 m of room or in buildings.
[[nodiscard]] std::vector<StructureFace> track_faces(std::span<const Polyline> tracks, const FreeSpace& space,
                                                     const Ground& ground);

/// Outlines of roads must reach this far: half a piece of track and its ballast.
constexpr double track_reach_m = 6.0;

struct PlacedLamp {
  Vec3 foot;  ///< site CRS
  double yaw_rad = 0.0;
};
/// Lamps with 0.3 m of room, their arms towards the nearest road within 8 m.
[[nodiscard]] std::vector<PlacedLamp> place_lamps(std::span<const Vec2> lamps, const RoadLevel& roads,
                                                  const FreeSpace& space, const Ground& ground);
/// Their copies; positions relative to `origin`.
[[nodiscard]] InstancedMesh lamp_instances(std::span<const PlacedLamp* const> lamps, Vec3 origin);

}  // namespace orthodrive::scene
