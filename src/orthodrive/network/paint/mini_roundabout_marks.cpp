// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/mini_roundabout_marks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Road;
using roadquery::RoadMap;

constexpr double foot_step_m = 0.25, off_middle_m = 0.2;
constexpr double least_disc_mark_m = 1.0, most_disc_mark_m = 4.0;
constexpr double disc_mark_share = 0.25;  // of the disc

struct MarkPlace {
  Road* road = nullptr;
  double s = 0.0, t = 0.0;
};

/// Where the disc's middle lies straight beside a road's line; of several the nearest.
MarkPlace place_beside(const MiniRoundaboutDisc& disc, RoadMap& map) {
  MarkPlace best;
  for (Road& road : map.roads) {
    const auto begin = roadquery::reference_point(road, 0.0);
    if (road.sections.empty() || distance({begin.x, begin.y}, disc.middle) > road.length + disc.radius_m) continue;
    const int steps = std::max(1, static_cast<int>(std::ceil(road.length / foot_step_m)));
    for (int i = 0; i <= steps; ++i) {
      const double s = road.length * i / steps;
      const auto q = roadquery::reference_point(road, s);
      const Vec2 along{std::cos(q.hdg), std::sin(q.hdg)}, off = disc.middle - Vec2{q.x, q.y};
      const double t = cross(along, off);
      if (std::abs(dot(along, off)) > off_middle_m || std::abs(t) > disc.radius_m) continue;
      if (!best.road || std::abs(t) < std::abs(best.t) - 0.01) best = {&road, s, t};
    }
  }
  return best;
}

}  // namespace

void add_mini_roundabout_marks(std::span<const MiniRoundaboutDisc> discs, RoadMap& map) {
  for (const MiniRoundaboutDisc& disc : discs) {
    const MarkPlace place = place_beside(disc, map);
    if (!place.road) continue;
    const double across_m = std::clamp(disc_mark_share * 2.0 * disc.radius_m, least_disc_mark_m, most_disc_mark_m);
    place.road->objects.push_back({.type = "roadMark",
                                   .subtype = "paint",
                                   .name = mini_roundabout_mark,
                                   .s = place.s,
                                   .t = place.t,
                                   .length = across_m,
                                   .width = across_m});
  }
}

std::map<int, Polygon> paved_middles(std::span<const MiniRoundaboutDisc> discs, const RoadMap& map) {
  std::map<int, Polygon> paved;
  constexpr int corners = 32;
  for (const MiniRoundaboutDisc& disc : discs) {
    int first = -1;
    for (const Road& road : map.roads) {
      if (road.junction < 0 || paved.contains(road.junction) || (first >= 0 && road.junction >= first)) continue;
      const auto p = roadquery::reference_point(road, 0.5 * road.length);
      if (distance({p.x, p.y}, disc.middle) < disc.radius_m) first = road.junction;
    }
    if (first < 0) continue;
    Ring& ring = paved[first].outer;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / corners;
      ring.push_back(disc.middle + Vec2{std::cos(angle), std::sin(angle)} * disc.lane_m);
    }
  }
  return paved;
}

}  // namespace orthodrive::network
