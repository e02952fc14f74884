// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/raise_sidewalks.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "orthodrive/network/junctions/roads_over.hpp"
#include "orthodrive/network/lanes/sidewalk_lanes.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double raised_step_m = 0.5;  // between places that are asked whether something lies on the sidewalk
constexpr double sidewalk_height_unit_m = 1e-3;

/// The sidewalk lies at most so high between two s.
struct Limit {
  double from = 0.0, to = 0.0, height_m = 0.0;
};

struct Walk : SidewalkLane {
  std::vector<Limit> limits;

  [[nodiscard]] double height(double s) const {
    double height = kerb_m;
    for (const Limit& limit : limits) {
      const double beside = std::max({limit.from - s, s - limit.to, 0.0});
      height = std::min(height, limit.height_m + beside * (kerb_m / kerb_ramp_m));
    }
    return height;
  }
};

void add_own_limits(const Road& road, const Lane& lane, Walk& walk) {
  if (!lane.predecessor) walk.limits.push_back({0.0, 0.0, 0.0});
  if (!lane.successor) walk.limits.push_back({road.length, road.length, 0.0});
  for (const roadquery::RoadObject& object : road.objects)
    if (object.type == "crosswalk")
      walk.limits.push_back({object.s - 0.5 * object.length, object.s + 0.5 * object.length, lowered_kerb_m});
}

void add_limits_of_others(const RoadsOver& roads, const Road& road, const Lane& lane, Walk& walk) {
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / raised_step_m)));
  std::optional<Limit> open;
  for (int i = 0; i <= steps + 1; ++i) {
    const double s = road.length * std::min(i, steps) / steps;
    bool covered = false;
    if (i <= steps) {
      const double inner = walk.inner_t(road, s), outer = (walk.left ? 1.0 : -1.0) * roadquery::lane_width(lane, s);
      for (const double share : {0.02, 0.5, 0.98}) {
        const roadquery::SurfacePoint p = roadquery::surface_point(road, s, inner + share * outer);
        covered = covered || roads.is_carriageway(p, walk.road) || roads.is_junction(p);
      }
    }
    if (covered && !open) open = Limit{s - raised_step_m, s + raised_step_m, 0.0};
    if (covered) open->to = s + raised_step_m;
    if (!covered && open) walk.limits.push_back(*open), open.reset();
  }
}

/// Joints of two roads: both sides as high as the lower one.
bool level_joints(const RoadMap& map, const std::vector<SidewalkJoint>& joints, std::vector<Walk>& walks) {
  bool changed = false;
  for (const SidewalkJoint& joint : joints) {
    Walk& walk = walks[joint.walk];
    const double here = joint.at_end ? map.roads[walk.road].length : 0.0;
    double there_m = 0.0;
    if (joint.next < walks.size()) {
      const Walk& next = walks[joint.next];
      there_m = next.height(joint.next_at_end ? map.roads[next.road].length : 0.0);
    }
    if (there_m >= walk.height(here) - 1e-9) continue;
    walk.limits.push_back({here, here, there_m});
    changed = true;
  }
  return changed;
}

std::vector<roadquery::LaneHeight> entries_of(const Walk& walk, double length) {
  std::vector<double> places = {0.0, length};
  const auto add = [&](double s) {
    if (s > 0.0 && s < length) places.push_back(s);
  };
  for (const Limit& a : walk.limits) {
    const double ramp = (kerb_m - a.height_m) * (kerb_ramp_m / kerb_m);
    for (const double s : {a.from - ramp, a.from, a.to, a.to + ramp}) add(s);
    for (const Limit& b : walk.limits)  // where the ramp up from a is as high as that down to b
      if (b.from > a.to) add(0.5 * (a.to + b.from + (b.height_m - a.height_m) * (kerb_ramp_m / kerb_m)));
  }
  std::ranges::sort(places);
  std::vector<roadquery::LaneHeight> entries;
  constexpr double apart_m = 1e-3;
  for (const double s : places) {
    if (!entries.empty() && s - entries.back().s_offset < apart_m) continue;
    const double height = std::round(walk.height(s) / sidewalk_height_unit_m) * sidewalk_height_unit_m;
    const std::size_t n = entries.size();
    if (n > 1 && entries[n - 1].inner == height && entries[n - 2].inner == height) entries.pop_back();
    entries.push_back({s, height, height});
  }
  return entries;
}

}  // namespace

void raise_sidewalks(RoadMap& map) {
  const std::vector<SidewalkLane> lanes = sidewalk_lanes(map);
  if (lanes.empty()) return;
  const RoadsOver roads(map);
  std::vector<Walk> walks;
  for (const SidewalkLane& of : lanes) {
    const Road& road = map.roads[of.road];
    Walk& walk = walks.emplace_back(Walk{of, {}});
    add_own_limits(road, *of.lane(map), walk);
    add_limits_of_others(roads, road, *of.lane(map), walk);
  }
  const std::vector<SidewalkJoint> joints = sidewalk_joints(map, lanes);
  constexpr int most_rounds = 8;
  for (int round = 0; round < most_rounds && level_joints(map, joints, walks); ++round) {
  }
  for (const Walk& walk : walks) walk.lane(map)->heights = entries_of(walk, map.roads[walk.road].length);
}

}  // namespace orthodrive::network
