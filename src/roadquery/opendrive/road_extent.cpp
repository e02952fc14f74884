// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/road_extent.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "roadquery/roads/road_ends.hpp"
#include "roadquery/surface/shift_cubic.hpp"

namespace roadquery {
namespace {

constexpr double no_length_m = 1e-6;      // of a <geometry>: less than what coordinates are rounded to
constexpr double no_section_m = 1e-3;     // of a <laneSection>: nobody can use lanes of a millimetre
constexpr double length_off_m = 0.01;     // sums of lengths that writers round to millimetres
constexpr double width_rounded_m = 0.01;  // polynomials that are to end at 0 pass it by so much

void note_late(const Road& road, const char* element, double from_s, NoteList& notes) {
  notes.add("opendrive.begins_late",
            std::string("the first <") + element +
                "> begins behind the start, where the standard wants one: it holds from the start on",
            true, {road.id, from_s});
}

/// The same polynomial, its s measured from the start on.
void hold_from(double start, std::vector<Cubic>& cubics) {
  Cubic& first = cubics.front();
  double shifted[4];
  shift_cubic({first.a, first.b, first.c, first.d}, start - first.s, shifted);
  first = {start, shifted[0], shifted[1], shifted[2], shifted[3]};
}

/// Moves the start of the first section to that of the road; what begins with the section still does.
void begin_section_at_0(Road& road, NoteList& notes) {
  LaneSection& section = road.sections.front();
  const double late_m = section.s;
  if (!(late_m > 0.0)) return;
  if (late_m > no_section_m) note_late(road, "laneSection", 0.0, notes);
  section.s = 0.0;
  const auto move = [&](auto& items, auto place) {
    for (auto& item : items)
      if (item.*place > 0.0) item.*place += late_m;
  };
  for (auto* side : {&section.left, &section.right})
    for (Lane& lane : *side) {
      for (Cubic& width : lane.width) width.s += late_m;
      if (!lane.width.empty() && lane.width.front().s <= late_m) hold_from(0.0, lane.width);
      move(lane.materials, &LaneMaterial::s_offset), move(lane.heights, &LaneHeight::s_offset);
      move(lane.speeds, &SpeedLimit::s), move(lane.marks, &RoadMark::s_offset);
    }
  move(section.center.marks, &RoadMark::s_offset);
}

/// Links of `section` to lanes of `gone` lead to where those led.
void link_through(LaneSection& section, const LaneSection& gone, std::optional<int> Lane::*link) {
  for (auto* side : {&section.left, &section.right})
    for (Lane& lane : *side) {
      const Lane* through = find_lane(gone, (lane.*link).value_or(0));  // 0 is no lane of a side
      if (through != nullptr) lane.*link = through->*link;
    }
}

void leave_out_short_sections(Road& road, NoteList& notes) {
  std::vector<LaneSection>& sections = road.sections;
  for (std::size_t i = 0; i < sections.size() && sections.size() > 1;) {
    const double end = i + 1 < sections.size() ? sections[i + 1].s : road.length;
    if (end - sections[i].s > no_section_m) {
      ++i;
      continue;
    }
    notes.add("opendrive.no_length", "<laneSection> elements without length are left out", false,
              {road.id, std::min(sections[i].s, road.length)});
    if (i > 0) link_through(sections[i - 1], sections[i], &Lane::successor);
    if (i + 1 < sections.size()) {
      link_through(sections[i + 1], sections[i], &Lane::predecessor);
    }
    sections.erase(sections.begin() + static_cast<std::ptrdiff_t>(i));
    if (i > 0) --i;  // it is longer now, and what comes behind it may be the last one
  }
}

void leave_out_short_geometry(Road& road, NoteList& notes) {
  for (std::size_t i = 0; i < road.plan.size() && road.plan.size() > 1;) {
    if (road.plan[i].length > no_length_m) {
      ++i;
      continue;
    }
    notes.add("opendrive.no_length", "<geometry> elements without length are left out", false,
              {road.id, road.plan[i].s});
    road.plan.erase(road.plan.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void note_road_length(const Road& road, NoteList& notes) {
  const auto add = [&](const char* what, double s) {
    notes.add("opendrive.road_length", what, true, {road.id, std::clamp(s, 0.0, road.length)});
  };
  if (road.plan.front().s > length_off_m) note_late(road, "geometry", 0.0, notes);
  for (std::size_t i = 1; i < road.plan.size(); ++i)
    if (std::abs(road.plan[i - 1].s + road.plan[i - 1].length - road.plan[i].s) > length_off_m)
      add("<geometry> elements do not follow each other along s: each holds until the next one begins", road.plan[i].s);
  const double over_m = road.plan.back().s + road.plan.back().length - road.length;
  if (over_m > length_off_m) add("a road is shorter than its <geometry> elements: it ends at its length", road.length);
  if (over_m < -length_off_m) add("a road is longer than its <geometry> elements: the last one goes on", road.length);
}

/// Least value of the polynomial in [from, to], both relative to its s.
double least(const Cubic& c, double from, double to) {
  const auto at = [&](double x) { return c.a + x * (c.b + x * (c.c + x * c.d)); };
  double low = std::min(at(from), at(to));
  const double root = c.c * c.c - 3.0 * c.b * c.d;
  for (const double x : {c.d != 0.0 && root >= 0.0 ? (-c.c + std::sqrt(root)) / (3.0 * c.d) : from,
                         c.d != 0.0 && root >= 0.0 ? (-c.c - std::sqrt(root)) / (3.0 * c.d) : from,
                         c.d == 0.0 && c.c != 0.0 ? -c.b / (2.0 * c.c) : from})
    if (x > from && x < to) low = std::min(low, at(x));
  return low;
}

void check_width(const Road& road, double section_s, double section_m, Lane& lane, NoteList& notes) {
  if (lane.width.empty()) {
    notes.add("opendrive.no_width", "a <lane> has neither <width> nor <border>: it is 0 m wide", true,
              {road.id, section_s});
    return;
  }
  if (lane.width.front().s > 0.0) {
    if (lane.width.front().s > no_section_m) note_late(road, "width", section_s, notes);
    hold_from(0.0, lane.width);
  }
  for (std::size_t i = 0; i < lane.width.size(); ++i) {
    const Cubic& c = lane.width[i];
    const double to = std::min(i + 1 < lane.width.size() ? lane.width[i + 1].s : section_m, section_m) - c.s;
    if (!(to > 0.0) || least(c, 0.0, to) >= -width_rounded_m) continue;
    notes.add("opendrive.negative_width", "a <lane> is narrower than nothing: its borders cross", true,
              {road.id, section_s + c.s});
    return;
  }
}

}  // namespace

void fit_to_road(Road& road, NoteList& notes) {
  leave_out_short_geometry(road, notes);
  note_road_length(road, notes);
  if (!road.elevation.empty() && road.elevation.front().s > 0.0) {
    if (road.elevation.front().s > no_section_m) note_late(road, "elevation", 0.0, notes);
    hold_from(0.0, road.elevation);
  }
  leave_out_short_sections(road, notes);
  begin_section_at_0(road, notes);
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    LaneSection& section = road.sections[i];
    const double end = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
    for (auto* side : {&section.left, &section.right})
      for (Lane& lane : *side) check_width(road, section.s, end - section.s, lane, notes);
  }
}

}  // namespace roadquery
