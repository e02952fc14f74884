// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/line/road_beside.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/blend.hpp"

namespace orthodrive {
namespace {

constexpr double reach_m = 4.0, step_m = 0.1, tolerance_m = 0.01;

/// Distance to the edge in one direction from a place so far along it that is on the road.
double room(const roadquery::RoadQuery& query, const LinePoint& from, Vec2 direction, double begin_m) {
  roadquery::Cursor cursor;
  double z = from.z_m;
  const auto on_road = [&](double at_m) {
    const auto hit = place_for_car(query, from.x_m + at_m * direction.x, from.y_m + at_m * direction.y, z, cursor);
    if (!hit) return false;
    z = hit->z;
    return true;
  };
  const double most_m = begin_m + reach_m;
  double inside = begin_m;
  while (inside + step_m <= most_m && on_road(inside + step_m)) inside += step_m;
  if (inside + step_m > most_m) return most_m;
  double outside = inside + step_m;
  while (outside - inside > tolerance_m) {
    const double middle = 0.5 * (inside + outside);
    (on_road(middle) ? inside : outside) = middle;
  }
  return inside;
}

}  // namespace

bool is_for_driving(const roadquery::RoadMap& map, const roadquery::Hit& hit) {
  if (hit.in_junction) return true;
  const auto& section = roadquery::section_at(map.roads[static_cast<std::size_t>(hit.road)], hit.s);
  const auto& lanes = hit.lane_id < 0 ? section.right : section.left;
  const auto index = static_cast<std::size_t>(std::abs(hit.lane_id));
  // On the centre line or exactly on an edge no lane is named.
  return index == 0 || index > lanes.size() || roadquery::is_driven(lanes[index - 1].type);
}

std::optional<roadquery::Hit> place_for_car(const roadquery::RoadQuery& query, double x_m, double y_m, double z_m,
                                            roadquery::Cursor& cursor) {
  const auto hit = query.find(x_m, y_m, z_m, cursor);
  if (!hit || !roadquery::is_same_level(hit->z, z_m) || !is_for_driving(query.map(), *hit)) return {};
  return hit;
}

std::vector<Room> room_beside(const roadquery::RoadQuery& query, const DrivingLine& line,
                              const std::vector<double>& lane_m) {
  const std::size_t count = line.points.size() - (line.closed ? 1 : 0);
  std::vector<Room> rooms(count, {reach_m, reach_m});
  roadquery::Cursor cursor;
  for (std::size_t i = 0; i < count; ++i) {
    const LinePoint& p = line.points[i];
    const Vec2 left = {-std::sin(p.heading_rad), std::cos(p.heading_rad)};
    for (const double from_m : {0.0, lane_m[i]}) {
      if (!place_for_car(query, p.x_m + from_m * left.x, p.y_m + from_m * left.y, p.z_m, cursor)) continue;
      rooms[i] = {room(query, p, -1.0 * left, -from_m), room(query, p, left, from_m)};
      break;
    }
  }
  return rooms;
}

}  // namespace orthodrive
