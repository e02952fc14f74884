// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tunnels: where the ground is opened over their roads, tubes, portals and the walls of the cuttings before them.

#include <span>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/scene/ground/ground_surface.hpp"
#include "orthodrive/scene/roads/road_level.hpp"
#include "orthodrive/scene/structures/structures.hpp"

namespace orthodrive::scene {

struct TunnelInput {
  const RoadLevel& roads;  ///< on the ground
  std::span<const RoadLevel> tunnels;
  const Ground& ground;
  const roadquery::RoadQuery& query;
  const RoadJoints& joints;
  const Outline& area;
};

/// A tube is the road and a walkway of 0.75 m along each side, 0.12 m high. Its vault is 4.7 m above the road (5 m for
/// motorways and trunk roads, 3 m for paths), lower where the ground is, but no lower than 3.8 m (2.3 m for paths).
struct Tunnels {
  /// No ground lies here: where it would be lower than the lowest vault and 0.4 m of slab. On the plan grid, without
  /// overlaps, beside the roads on the ground.
  MultiPolygon openings;
  /// Inner faces of tubes; walls along openings, 0.4 m thick, up to 0.3 m above the ground beside them; portals: walls
  /// across where the vault begins, from it to 0.6 m above the ground. Nothing stands where another road runs.
  std::vector<StructureFace> faces;
  std::vector<Vec2> ground_points;  ///< the ground needs vertices here: over vaults that lie near below it
  Findings findings;                ///< "scene.tunnel_without_cover": 30 m and more of a tunnel lie in the open
};

/// Looks at stations at most 2 m apart, and at nothing further than 6 m from each: the same for every tile.
[[nodiscard]] Tunnels build_tunnels(const TunnelInput& input, const MultiPolygon& area);

}  // namespace orthodrive::scene
