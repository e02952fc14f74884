// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/free_space.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "orthodrive/geo/segment.hpp"

namespace orthodrive::scene {
namespace {

/// 0 inside.
double distance_to(Vec2 p, const Polygon& polygon) {
  if (contains(polygon, p)) return 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i)
      nearest = std::min(nearest, distance_to_segment(ring[i], ring[(i + 1) % ring.size()], p));
  };
  add(polygon.outer);
  for (const Ring& hole : polygon.holes) add(hole);
  return nearest;
}

/// How far a roof stands out over its walls.
double roof_reach_m(const PlacedBuilding& building) {
  return building.eaves_m.empty() ? 0.0 : std::ranges::max(building.eaves_m);
}

}  // namespace

FreeSpace::FreeSpace(const Obstacles& obstacles) : obstacles_(obstacles) {
  std::vector<Box2> boxes;
  boxes.reserve(obstacles.buildings.size());
  for (const PlacedBuilding& building : obstacles.buildings)
    boxes.push_back(bounds_of(moved(building.footprint, building.middle).outer).grown(roof_reach_m(building)));
  index_ = SpatialIndex(boxes);
}

double FreeSpace::around(Vec2 p, double radius_m, const FreeOf& but) const {
  if (!obstacles_.area.contains(p) || obstacles_.openings.contains(p)) return 0.0;
  double free_m = std::min(radius_m, obstacles_.openings.nearest(p).distance_m);
  for (const RoadLevel* level : obstacles_.levels) {
    const NearestBorder border = level->outline().nearest(p);
    if (level->outline().contains(p)) {
      const auto on = level->sample(p);
      if (!on || on->z_m <= but.below_z_m) return 0.0;
    } else if (border.distance_m < free_m && border.z_m <= but.below_z_m) {
      free_m = border.distance_m;
    }
  }
  for (const std::uint32_t i : index_.near(p, free_m)) {
    if (i == but.besides) continue;
    const PlacedBuilding& building = obstacles_.buildings[i];
    const double away_m = distance_to(p - building.middle, building.footprint);
    free_m = std::min(free_m, std::max(0.0, away_m - roof_reach_m(building)));
  }
  return free_m;
}

}  // namespace orthodrive::scene
