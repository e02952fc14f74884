// SPDX-License-Identifier: Apache-2.0
#include "roadquery/roads/speed_limits.hpp"

#include <algorithm>

#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

/// The last entry that begins at s or before; 0 before the first.
double limit_at(const std::vector<SpeedLimit>& limits, double s) {
  double mps = 0.0;
  for (const SpeedLimit& limit : limits) {
    if (limit.s > s) break;
    mps = limit.mps;
  }
  return mps;
}

double limit_of(const Road& road, const Lane& lane, double s, double s_in_section) {
  const double own = limit_at(lane.speeds, s_in_section);
  return own > 0.0 ? own : road_limit_mps(road, s);
}

}  // namespace

double road_limit_mps(const Road& road, double s) {
  return road.speed_limits.empty() ? road.speed_limit_mps : limit_at(road.speed_limits, s);
}

double lane_limit_mps(const Road& road, int lane_id, double s) {
  if (road.sections.empty()) return road_limit_mps(road, s);
  const LaneSection& section = section_at(road, s);
  for (const Lane& lane : lane_id > 0 ? section.left : section.right)
    if (lane.id == lane_id) return limit_of(road, lane, s, s - section.s);
  return road_limit_mps(road, s);
}

double fastest_limit_mps(const Road& road, double s, LimitSide side) {
  if (road.sections.empty()) return road_limit_mps(road, s);
  const LaneSection& section = section_at(road, s);
  double fastest = -1.0;
  const auto look = [&](const std::vector<Lane>& lanes) {
    for (const Lane& lane : lanes)
      if (lane.type == LaneType::driving) fastest = std::max(fastest, limit_of(road, lane, s, s - section.s));
  };
  if (side != LimitSide::right) look(section.left);
  if (side != LimitSide::left) look(section.right);
  return fastest >= 0.0 ? fastest : road_limit_mps(road, s);
}

bool has_lane_limits(const Road& road) {
  if (road.speed_limits.size() > 1) return true;
  const auto limited = [](const Lane& lane) { return !lane.speeds.empty(); };
  return std::any_of(road.sections.begin(), road.sections.end(), [&](const LaneSection& section) {
    return std::any_of(section.left.begin(), section.left.end(), limited) ||
           std::any_of(section.right.begin(), section.right.end(), limited);
  });
}

}  // namespace roadquery
