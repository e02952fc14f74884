// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/follow_mark_rule.hpp"

#include <algorithm>

#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/network/lanes/lanes.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::LaneType;
using roadquery::RoadMark;

bool has_traffic(const std::vector<Lane>& lanes) {
  return std::ranges::any_of(lanes, [](const Lane& lane) {
    return roadquery::is_driven(lane.type) || lane.type == LaneType::bus || lane.type == LaneType::taxi;
  });
}

bool has_shared_lane(const roadquery::LaneSection& section) {
  const auto is_shared = [](const Lane& lane) { return lane.type == LaneType::bidirectional; };
  return std::ranges::any_of(section.left, is_shared) || std::ranges::any_of(section.right, is_shared);
}

void paint_between_directions(const RoadMarkRule& rule, Lane& lane) {
  for (RoadMark& mark : lane.marks) {
    if (mark.type == "none") continue;
    mark.color = rule.between_directions;
    if (rule.is_solid_centre_double && mark.type == "solid") mark.type = "solid solid";
  }
}

/// The strokes of a road with this limit; null where the rule has none.
const StrokeRule* strokes_of(const RoadMarkRule& rule, double speed_mps) {
  constexpr double rounding_kmh = 0.5;
  for (const StrokeRule& strokes : rule.strokes)
    if (speed_mps * kmh_per_mps <= strokes.to_kmh + rounding_kmh) return &strokes;
  return rule.strokes.empty() ? nullptr : &rule.strokes.back();
}

void write_out_strokes(const StrokeRule& strokes, Lane& lane) {
  for (RoadMark& mark : lane.marks)
    if (mark.type == "broken" && mark.lines.empty())
      mark.lines.push_back({.length = strokes.stroke_m, .space = strokes.gap_m});
}

}  // namespace

void follow_mark_rule(const RoadMarkRule& rule, roadquery::RoadMap& map) {
  for (roadquery::Road& road : map.roads) {
    const StrokeRule* strokes = strokes_of(rule, road.speed_limit_mps);
    for (roadquery::LaneSection& section : road.sections) {
      const bool both_ways = has_traffic(section.left) && has_traffic(section.right);
      if (both_ways) {
        paint_between_directions(rule, section.center);
      } else if (!has_shared_lane(section) && !is_raceway(road.highway)) {
        for (RoadMark& mark : section.center.marks) mark.color = rule.inner_edge;
      }
      if (strokes) write_out_strokes(*strokes, section.center);
      for (auto* side : {&section.left, &section.right})
        for (Lane& lane : *side) {
          if (both_ways && lane.type == LaneType::bidirectional) paint_between_directions(rule, lane);
          if (strokes) write_out_strokes(*strokes, lane);
        }
    }
  }
}

}  // namespace orthodrive::network
