// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/header_offset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roadquery {
namespace {

/// Where the points of a file go.
struct Move {
  double turn_rad = 0.0, x = 0.0, y = 0.0, z = 0.0;

  void apply(double& px, double& py) const {
    if (turn_rad == 0.0) {
      px += x, py += y;
      return;
    }
    const double c = std::cos(turn_rad), n = std::sin(turn_rad), at_x = px;
    px = c * at_x - n * py + x, py = n * at_x + c * py + y;
  }
};

Move move_of(const RoadMap& map, HeaderOffset how) {
  const auto& [x, y, z] = map.header_offset_m;
  if (how == HeaderOffset::add) return {map.header_offset_hdg, x, y, z};
  Move back{-map.header_offset_hdg, 0.0, 0.0, -z};
  double to_x = -x, to_y = -y;
  back.apply(to_x, to_y);
  back.x = to_x, back.y = to_y;
  return back;
}

void move_bounds(RoadMap& map, const Move& move) {
  if (move.turn_rad == 0.0) {
    map.north += move.y, map.south += move.y, map.east += move.x, map.west += move.x;
    return;
  }
  constexpr double inf = std::numeric_limits<double>::infinity();
  double west = inf, east = -inf, south = inf, north = -inf;
  for (double x : {map.west, map.east})
    for (double y : {map.south, map.north}) {
      double at_x = x, at_y = y;
      move.apply(at_x, at_y);
      west = std::min(west, at_x), east = std::max(east, at_x);
      south = std::min(south, at_y), north = std::max(north, at_y);
    }
  map.west = west, map.east = east, map.south = south, map.north = north;
}

void move_road(Road& road, const Move& move) {
  for (PlanElement& element : road.plan) {
    move.apply(element.x, element.y);
    element.hdg += move.turn_rad;
  }
  if (road.elevation.empty()) road.elevation.emplace_back();
  for (Cubic& elevation : road.elevation) elevation.a += move.z;
  for (SurfaceCrg& crg : road.surface) {
    move.apply(crg.x_offset, crg.y_offset);
    if (crg.mode == "global") crg.h_offset += move.turn_rad;
    if (crg.mode != "attached" && crg.purpose == "elevation") crg.z_offset += move.z;
  }
}

void move_surface(JunctionSurface& surface, const Move& move) {
  for (auto& [border_x, border_y] : surface.boundary) border_x += move.x, border_y += move.y;
  surface.x += move.x, surface.y += move.y;
  for (double& height : surface.z) height += move.z;
}

}  // namespace

void apply_header_offset(RoadMap& map, HeaderOffset how, NoteList& notes) {
  if (how == HeaderOffset::ignore) return;
  const Move move = move_of(map, how);
  if (move.turn_rad == 0.0 && move.x == 0.0 && move.y == 0.0 && move.z == 0.0) return;
  move_bounds(map, move);
  for (Road& road : map.roads) move_road(road, move);
  for (Junction& junction : map.junctions) {
    if (!junction.surface) continue;
    if (move.turn_rad == 0.0) {
      move_surface(*junction.surface, move);
      continue;
    }
    junction.surface.reset();
    notes.add("opendrive.turned_junction",
              "the <offset> has a heading, so junctions' own surfaces are not read: the roads' heights count there",
              true);
  }
}

}  // namespace roadquery
