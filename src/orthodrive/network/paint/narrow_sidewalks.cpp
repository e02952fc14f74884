// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/narrow_sidewalks.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/network/junctions/roads_over.hpp"
#include "orthodrive/network/lanes/sidewalk_lanes.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::Road;
using roadquery::RoadMap;

constexpr double sidewalk_step_m = 0.5, sidewalk_across_step_m = 0.1;
constexpr double sidewalk_taper = 0.5;     // change of the width, m per m
constexpr double sidewalk_margin_m = 0.1;  // kept to the other carriageway: between two places it may come nearer
constexpr double least_free_m = 0.3;       // nobody walks on less

/// Widths at evenly spaced places of one road, its ends included.
struct Widths {
  double apart_m = 0.0;
  std::vector<double> m;

  [[nodiscard]] double& at(bool end) { return end ? m.back() : m.front(); }
  /// Everywhere at most what the taper allows beside the other places.
  void taper_off() {
    for (std::size_t i = 1; i < m.size(); ++i) m[i] = std::min(m[i], m[i - 1] + sidewalk_taper * apart_m);
    for (std::size_t i = m.size() - 1; i-- > 0;) m[i] = std::min(m[i], m[i + 1] + sidewalk_taper * apart_m);
  }
};

/// Width from the inner border out to another carriageway.
double free_width_m(const RoadsOver& roads, const Road& road, const SidewalkLane& walk, double s, double width_m) {
  const double inner = walk.inner_t(road, s), outwards = walk.left ? 1.0 : -1.0;
  const int steps = static_cast<int>(std::ceil((width_m + sidewalk_margin_m) / sidewalk_across_step_m));
  for (int i = 0; i <= steps; ++i) {
    const double out_m = std::min(i * sidewalk_across_step_m, width_m + sidewalk_margin_m);
    if (!roads.is_carriageway(roadquery::surface_point(road, s, inner + outwards * out_m), walk.road)) continue;
    const double free_m = out_m - sidewalk_across_step_m - sidewalk_margin_m;
    return free_m < least_free_m ? 0.0 : free_m;
  }
  return width_m;
}

Widths free_widths(const RoadsOver& roads, const Road& road, const SidewalkLane& walk, const Lane& lane) {
  const int steps = std::max(1, static_cast<int>(std::ceil(road.length / sidewalk_step_m)));
  Widths widths{road.length / steps, {}};
  for (int i = 0; i <= steps; ++i) {
    const double s = road.length * i / steps;
    widths.m.push_back(free_width_m(roads, road, walk, s, roadquery::lane_width(lane, s)));
  }
  widths.taper_off();
  return widths;
}

/// Straight between the places.
std::vector<roadquery::Cubic> cubics_of(const Widths& widths) {
  constexpr double same_slope = 1e-9;
  std::vector<roadquery::Cubic> cubics;
  for (std::size_t i = 0; i + 1 < widths.m.size(); ++i) {
    const double slope = (widths.m[i + 1] - widths.m[i]) / widths.apart_m;
    if (!cubics.empty() && std::abs(cubics.back().b - slope) < same_slope) continue;
    cubics.push_back({static_cast<double>(i) * widths.apart_m, widths.m[i], slope, 0.0, 0.0});
  }
  return cubics;
}

}  // namespace

void narrow_sidewalks(RoadMap& map) {
  const std::vector<SidewalkLane> walks = sidewalk_lanes(map);
  if (walks.empty()) return;
  std::vector<Widths> widths;
  {
    const RoadsOver roads(map);
    for (const SidewalkLane& walk : walks)
      widths.push_back(free_widths(roads, map.roads[walk.road], walk, *walk.lane(map)));
  }
  const std::vector<SidewalkJoint> joints = sidewalk_joints(map, walks);
  for (bool changed = true; changed;) {
    changed = false;
    for (const SidewalkJoint& joint : joints) {
      if (joint.next == walks.size()) continue;
      double& width_m = widths[joint.walk].at(joint.at_end);
      const double there_m = widths[joint.next].at(joint.next_at_end);
      if (there_m >= width_m) continue;
      width_m = there_m, widths[joint.walk].taper_off(), changed = true;
    }
  }
  for (std::size_t i = 0; i < walks.size(); ++i) {
    Lane& lane = *walks[i].lane(map);
    const double whole_m = roadquery::lane_width(lane, 0.0);
    if (std::ranges::any_of(widths[i].m, [&](double m) { return m < whole_m; })) lane.width = cubics_of(widths[i]);
  }
}

}  // namespace orthodrive::network
