// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/finish_road.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "roadquery/opendrive/border_widths.hpp"
#include "roadquery/opendrive/car_access.hpp"
#include "roadquery/opendrive/level_lanes.hpp"
#include "roadquery/opendrive/road_extent.hpp"
#include "roadquery/opendrive/single_sides.hpp"
#include "roadquery/roads/road_structures.hpp"

namespace roadquery {
namespace {

constexpr double same_row_m = 1e-6;  // writers round the places of one row differently

/// Of which element of which road a list is.
struct Listed {
  const Road& road;
  const char* element;
  NoteList& notes;
  double from_s = 0.0;  ///< where the list's s begins

  void note_unsorted(double s) const {
    notes.add("opendrive.not_sorted", std::string("<") + element + "> elements were not in order and have been sorted",
              false, {road.id, from_s + s});
  }
  void note_repeated(double s) const {
    notes.add("opendrive.repeated",
              std::string("<") + element + "> elements stand at one place more than once, the last one counts", false,
              {road.id, from_s + s});
  }
};

/// Sorts by place(item); stable.
template <typename Item, typename Place>
void sort_along(std::vector<Item>& items, const Listed& listed, const Place& place) {
  const auto before = [&](const Item& a, const Item& b) { return place(a) < place(b); };
  const auto unsorted = std::is_sorted_until(items.begin(), items.end(), before);
  if (unsorted == items.end()) return;
  listed.note_unsorted(place(*unsorted));
  std::stable_sort(items.begin(), items.end(), before);
}

/// Of sorted items at one place, at most `apart_m` from the first of them, leaves the last one.
template <typename Item, typename Place>
void keep_last(std::vector<Item>& items, const Listed& listed, const Place& place, double apart_m) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (kept > 0 && place(items[i]) - place(items[kept - 1]) <= apart_m) {
      listed.note_repeated(place(items[i]));
      const double s = place(items[kept - 1]);
      items[kept - 1] = std::move(items[i]);
      place(items[kept - 1]) = s;
    } else {
      if (kept != i) items[kept] = std::move(items[i]);
      ++kept;
    }
  }
  items.resize(kept);
}

template <typename Item, typename Place>
void put_in_order(std::vector<Item>& items, const Listed& listed, const Place& place, double apart_m = 0.0) {
  sort_along(items, listed, place);
  keep_last(items, listed, place, apart_m);
}

constexpr auto s_of = [](auto& item) -> auto& { return item.s; };
constexpr auto offset_of_item = [](auto& item) -> auto& { return item.s_offset; };

void order_shapes(Road& road, NoteList& notes) {
  std::vector<ShapeCubic>& shapes = road.shape;
  const Listed listed{road, "shape", notes};
  const auto before = [](const ShapeCubic& a, const ShapeCubic& b) { return a.s != b.s ? a.s < b.s : a.t < b.t; };
  const auto unsorted = std::is_sorted_until(shapes.begin(), shapes.end(), before);
  if (unsorted != shapes.end()) {
    std::stable_sort(shapes.begin(), shapes.end(), [](const ShapeCubic& a, const ShapeCubic& b) { return a.s < b.s; });
  }
  for (std::size_t i = 1, first = 0; i < shapes.size(); ++i) {
    if (shapes[i].s - shapes[first].s > same_row_m) first = i;
    shapes[i].s = shapes[first].s;
  }
  std::stable_sort(shapes.begin(), shapes.end(), before);
  const std::size_t all = shapes.size();
  std::vector<ShapeCubic> kept;
  for (const ShapeCubic& shape : shapes) {
    if (!kept.empty() && kept.back().s == shape.s && shape.t - kept.back().t <= same_row_m) {
      listed.note_repeated(shape.s);
      const double t = kept.back().t;
      kept.back() = shape, kept.back().t = t;
    } else {
      kept.push_back(shape);
    }
  }
  if (unsorted != shapes.end() && kept.size() == all) listed.note_unsorted(kept.front().s);
  shapes = std::move(kept);
}

void order_lane(const Road& road, double section_s, Lane& lane, NoteList& notes) {
  const auto listed = [&](const char* element) { return Listed{road, element, notes, section_s}; };
  put_in_order(lane.width, listed("width"), s_of);
  put_in_order(lane.marks, listed("roadMark"), offset_of_item);
  put_in_order(lane.materials, listed("material"), offset_of_item);
  put_in_order(lane.heights, listed("height"), offset_of_item, same_row_m);
  put_in_order(lane.speeds, listed("lane speed"), s_of);
}

/// From the middle outwards; of two lanes with one id the last one counts.
void order_lanes(const Road& road, double section_s, std::vector<Lane>& lanes, NoteList& notes) {
  std::stable_sort(lanes.begin(), lanes.end(),
                   [](const Lane& p, const Lane& q) { return std::abs(p.id) < std::abs(q.id); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const bool again = kept > 0 && lanes[kept - 1].id == lanes[i].id;
    if (again)
      notes.add("opendrive.repeated", "two <lane> elements of one section have one id, the last one counts", true,
                {road.id, section_s});
    const std::size_t to = again ? kept - 1 : kept++;
    if (to != i) lanes[to] = std::move(lanes[i]);
  }
  lanes.resize(kept);
  for (Lane& lane : lanes) order_lane(road, section_s, lane, notes);
}

void order_road(Road& road, NoteList& notes) {
  const auto listed = [&](const char* element) { return Listed{road, element, notes}; };
  sort_along(road.plan, listed("geometry"), s_of);
  put_in_order(road.elevation, listed("elevation"), s_of);
  put_in_order(road.superelevation, listed("superelevation"), s_of);
  put_in_order(road.lane_offset, listed("laneOffset"), s_of);
  put_in_order(road.speed_limits, listed("type"), s_of);
  order_shapes(road, notes);
  for (LaneSection& section : road.sections) {
    order_lane(road, section.s, section.center, notes);
    for (auto* side : {&section.left, &section.right}) order_lanes(road, section.s, *side, notes);
  }
}

/// By how much a half falls outwards for each metre.
double crossfall_slope(const std::vector<Cubic>& crossfall, double s) {
  const auto next =
      std::upper_bound(crossfall.begin(), crossfall.end(), s, [](double v, const Cubic& c) { return v < c.s; });
  if (next == crossfall.begin()) return 0.0;
  const auto found = next - 1;
  const double ds = s - found->s;
  return std::tan(found->a + ds * (found->b + ds * (found->c + ds * found->d)));
}

/// Places where rows of <shape> stand so that their slopes, linear in between, are those of the crossfall.
std::vector<double> crossfall_places(const Road& road, const RoadParts& parts) {
  constexpr double step_m = 2.0, jump_m = 0.01;
  std::vector<double> places = {0.0, road.length};
  for (const auto* half : {&parts.crossfall_left, &parts.crossfall_right}) {
    for (std::size_t i = 0; i < half->size(); ++i) {
      const Cubic& c = (*half)[i];
      const double end = std::min(i + 1 < half->size() ? (*half)[i + 1].s : road.length, road.length);
      if (c.s > jump_m && c.s < road.length) places.push_back(c.s - jump_m);
      if (c.s > 0.0 && c.s < road.length) places.push_back(c.s);
      if (c.b == 0.0 && c.c == 0.0 && c.d == 0.0) continue;
      const double begin = std::max(c.s, 0.0);
      const int steps = end > begin ? static_cast<int>((end - begin) / step_m) : 0;
      for (int k = 1; k <= steps; ++k) places.push_back(begin + (end - begin) * k / (steps + 1));
    }
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

/// A crossfall turns the halves of the cross section about the reference line, as two planes of <shape> do.
void add_crossfall(Road& road, RoadParts& parts, NoteList& notes) {
  constexpr double half_width_m = 500.0;  // of a road, at most (bake)
  if (parts.crossfall_left.empty() && parts.crossfall_right.empty()) return;
  if (!road.shape.empty()) {
    notes.add("opendrive.crossfall_beside_shape", "<crossfall> is passed over where a road has <shape>, too", true,
              {road.id, 0.0});
    return;
  }
  for (auto* half : {&parts.crossfall_left, &parts.crossfall_right})
    put_in_order(*half, {road, "crossfall", notes}, s_of);
  for (const double s : crossfall_places(road, parts)) {
    const double right = crossfall_slope(parts.crossfall_right, s), left = crossfall_slope(parts.crossfall_left, s);
    road.shape.push_back({s, -half_width_m, -right * half_width_m, right, 0.0, 0.0});
    road.shape.push_back({s, 0.0, 0.0, -left, 0.0, 0.0});
  }
}

void add_strips(Road& road, RoadParts& parts, NoteList& notes) {
  const auto order = [&](std::vector<Cubic>& list) { put_in_order(list, {road, "coefficients", notes}, s_of); };
  order(parts.surface.t_offset);
  for (SurfaceStrip& strip : parts.surface.strips)
    for (auto* list : {&strip.width, &strip.constant, &strip.linear, &strip.quadratic, &strip.cubic}) order(*list);
  shapes_from_strips(road, std::move(parts.surface), notes);
}

void sort_sections(Road& road, NoteList& notes) { sort_along(road.sections, {road, "laneSection", notes}, s_of); }

}  // namespace

void finish_road(Road& road, RoadParts parts, NoteList& notes) {
  order_road(road, notes);
  for (RoadParts::Border& border : parts.borders)
    put_in_order(border.t, {road, "border", notes, road.sections[border.section].s}, s_of);
  widths_from_borders(road, parts.borders, notes);
  read_lane_access(road, parts.accesses, notes);
  sort_sections(road, notes);
  continue_sides(road, parts.single_sides);
  fit_to_road(road, notes);
  add_strips(road, parts, notes);
  add_crossfall(road, parts, notes);
  keep_level_lanes(road, notes);
  finish_structures(road);
  const auto given = std::find_if(road.speed_limits.begin(), road.speed_limits.end(),
                                  [](const SpeedLimit& limit) { return limit.mps > 0.0 && std::isfinite(limit.mps); });
  if (given != road.speed_limits.end()) road.speed_limit_mps = given->mps;
}

}  // namespace roadquery
