// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/border_widths.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "roadquery/surface/shift_cubic.hpp"

namespace roadquery {
namespace {

/// The cubic that holds at s, in powers of the distance from s; the first one also before it where `extend`.
Cubic cubic_from(const std::vector<Cubic>& cubics, double s, bool extend) {
  const auto next = std::upper_bound(cubics.begin(), cubics.end(), s, [](double v, const Cubic& c) { return v < c.s; });
  if (cubics.empty() || (next == cubics.begin() && !extend)) return {s, 0.0, 0.0, 0.0, 0.0};
  const Cubic& c = next == cubics.begin() ? *next : *(next - 1);
  double moved[4];
  shift_cubic({c.a, c.b, c.c, c.d}, s - c.s, moved);
  return {s, moved[0], moved[1], moved[2], moved[3]};
}

/// factor_a a + factor_b b.
std::vector<Cubic> weighted_sum(const std::vector<Cubic>& a, double factor_a, const std::vector<Cubic>& b,
                                double factor_b) {
  std::set<double> starts = {0.0};
  for (const auto* list : {&a, &b})
    for (const Cubic& c : *list)
      if (c.s > 0.0) starts.insert(c.s);
  std::vector<Cubic> sum;
  for (const double s : starts) {
    const Cubic p = cubic_from(a, s, true), q = cubic_from(b, s, true);
    sum.push_back({s, factor_a * p.a + factor_b * q.a, factor_a * p.b + factor_b * q.b, factor_a * p.c + factor_b * q.c,
                   factor_a * p.d + factor_b * q.d});
  }
  return sum;
}

/// The lane offset from a section's start on, in the section's s.
std::vector<Cubic> offset_in_section(const Road& road, double section_s) {
  std::vector<Cubic> offset = {cubic_from(road.lane_offset, section_s, false)};
  offset.front().s = 0.0;
  for (const Cubic& c : road.lane_offset)
    if (c.s > section_s) offset.push_back({c.s - section_s, c.a, c.b, c.c, c.d});
  return offset;
}

/// Some writers give the right lanes' borders as distances.
void mind_sign(const Road& road, const LaneSection& section, bool left, std::vector<Cubic>& border, NoteList& notes) {
  if (left || border.empty()) return;
  const bool distances = std::all_of(border.begin(), border.end(), [](const Cubic& c) { return c.a >= 0.0; }) &&
                         std::any_of(border.begin(), border.end(), [](const Cubic& c) { return c.a > 0.0; });
  const double middle = cubic_from(road.lane_offset, section.s, false).a;
  if (!distances || border.front().a <= middle) return;
  notes.add("opendrive.border_sign", "<border> of right lanes is left of the middle, it is taken as a distance", true,
            {road.id, section.s});
  for (Cubic& c : border) c = {c.s, -c.a, -c.b, -c.c, -c.d};
}

/// The standard has one or the other (1.7, 11.5.2); the place of a border does not depend on the offset.
void note_offset(const Road& road, const std::vector<RoadParts::Border>& borders, NoteList& notes) {
  const bool moved = std::any_of(road.lane_offset.begin(), road.lane_offset.end(),
                                 [](const Cubic& c) { return c.a != 0.0 || c.b != 0.0 || c.c != 0.0 || c.d != 0.0; });
  if (borders.empty() || !moved) return;
  notes.add("opendrive.border_offset",
            "a road has <laneOffset> and <border>: borders are taken from the reference line, the offset moves the "
            "middle alone",
            true, {road.id, 0.0});
}

}  // namespace

void widths_from_borders(Road& road, const std::vector<RoadParts::Border>& borders, NoteList& notes) {
  std::set<std::size_t> sections;
  std::map<std::pair<std::size_t, int>, const RoadParts::Border*> of_lane;
  for (const RoadParts::Border& border : borders) {
    sections.insert(border.section);
    of_lane[{border.section, border.lane}] = &border;
  }
  note_offset(road, borders, notes);
  for (const std::size_t index : sections) {
    LaneSection& section = road.sections[index];
    for (const bool left : {true, false}) {
      const double sign = left ? 1.0 : -1.0;
      std::vector<Cubic> inner = offset_in_section(road, section.s);
      for (Lane& lane : left ? section.left : section.right) {
        const auto own = of_lane.find({index, lane.id});
        if (lane.width.empty() && own != of_lane.end()) {
          std::vector<Cubic> outer = own->second->t;
          mind_sign(road, section, left, outer, notes);
          lane.width = weighted_sum(outer, sign, inner, -sign);
          inner = std::move(outer);
        } else {
          inner = weighted_sum(inner, 1.0, lane.width, sign);
        }
      }
    }
  }
}

}  // namespace roadquery
