// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/lane_cuts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double chord_tolerance_m = 0.02;  // of chords from the borders, in plan
constexpr double longest_chord_m = 20.0;    // of chords: their ends carry the road's colour, too
constexpr double least_width_m = 0.2;       // of lanes: beside narrower ones there is one border for both
constexpr double cut_step_m = 5.0;          // lanes begin and end within this
constexpr double end_rounding_m = 1e-6;     // sections count up to their end

/// The border on the outer side of a lane, or for id 0 the middle of the road.
struct LaneBorder {
  const roadquery::Road& road;
  const roadquery::LaneSection& section;
  double start_m, end_m;  // of the section
  int lane_id;

  [[nodiscard]] double t_at(double s) const {
    double t = roadquery::evaluate(road.lane_offset, s);
    const bool left = lane_id > 0;
    const auto& lanes = left ? section.left : section.right;
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::abs(lane_id)) && i < lanes.size(); ++i)
      t += (left ? 1.0 : -1.0) * roadquery::lane_width(lanes[i], s - section.s);
    return t;
  }
  /// Whether the lanes inside and outside of it are there at s.
  [[nodiscard]] bool is_between_lanes(double s) const {
    const auto width = [&](int id) {
      const auto& lanes = id > 0 ? section.left : section.right;
      const auto i = static_cast<std::size_t>(std::abs(id)) - 1;
      return i < lanes.size() ? roadquery::lane_width(lanes[i], s - section.s) : 0.0;
    };
    if (lane_id == 0) return width(1) >= least_width_m && width(-1) >= least_width_m;
    return width(lane_id) >= least_width_m && width(lane_id + (lane_id > 0 ? 1 : -1)) >= least_width_m;
  }
  [[nodiscard]] Vec2 at(double s) const {
    const auto p = roadquery::surface_point(road, s, t_at(s));
    return {p.x, p.y};
  }
};

/// Calls use(border) for the borders of a section that may lie between two lanes.
template <typename Use>
void visit_borders(const roadquery::Road& road, std::size_t section, const Use& use) {
  const roadquery::LaneSection& of = road.sections[section];
  const double end_m = section + 1 < road.sections.size() ? road.sections[section + 1].s : road.length;
  const int left = static_cast<int>(of.left.size()), right = static_cast<int>(of.right.size());
  for (int id = 1 - right; id < left; ++id)
    if (id != 0 || (left > 0 && right > 0)) use(LaneBorder{road, of, of.s, end_m, id});
}

double to_chord_m(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  const double length_m = length(along);
  return length_m > 0.0 ? std::abs(cross(along, p - a)) / length_m : distance(p, a);
}

/// Appends the border after `from` up to `to`.
void append_chords(const LaneBorder& border, double from, double to, Polyline& line) {
  const Vec2 a = border.at(from), b = border.at(to);
  bool is_straight = to - from <= longest_chord_m;
  for (const double share : {0.25, 0.5, 0.75})
    is_straight = is_straight && to_chord_m(border.at(from + share * (to - from)), a, b) <= chord_tolerance_m;
  constexpr double shortest_m = 0.5;
  if (is_straight || to - from < 2.0 * shortest_m) {
    line.push_back(b);
    return;
  }
  append_chords(border, from, 0.5 * (from + to), line);
  append_chords(border, 0.5 * (from + to), to, line);
}

/// The joint's point at p, or p.
Vec2 at_joint(Vec2 p, std::span<const Vec2> joint) {
  constexpr double same_m = 0.01;
  for (const Vec2 q : joint)
    if (distance(p, q) < same_m) return q;
  return p;
}

void add_border(const LaneBorder& border, const EndPoints& joints, std::vector<Polyline>& cuts) {
  const int parts = std::max(1, static_cast<int>(std::ceil((border.end_m - border.start_m) / cut_step_m)));
  const auto s_of = [&](int k) {
    return k == parts ? border.end_m - end_rounding_m : border.start_m + (border.end_m - border.start_m) * k / parts;
  };
  for (int first = 0; first < parts; ++first) {
    if (!border.is_between_lanes(s_of(first)) || !border.is_between_lanes(s_of(first + 1))) continue;
    int last = first + 1;
    while (last < parts && border.is_between_lanes(s_of(last + 1))) ++last;
    Polyline line = {border.at(s_of(first))};
    append_chords(border, s_of(first), s_of(last), line);
    if (s_of(first) <= 0.0) line.front() = at_joint(line.front(), joints.start);
    if (last == parts && border.end_m >= border.road.length) line.back() = at_joint(line.back(), joints.end);
    for (Vec2& p : line) p = snap_to_grid(p);
    cuts.push_back(std::move(line));
    first = last;
  }
}

/// From edge to edge, through the ends of the cuts there and the reference line: beside a point of the plan grid that
/// lies a little off, a straight line would leave a triangle without height.
void add_across(const CrossSection& section, std::vector<Polyline>& cuts) {
  constexpr double off_line_m = 3.0 * plan_grid_m;
  const Vec2 right = snap_to_grid({section.right.x, section.right.y}),
             left = snap_to_grid({section.left.x, section.left.y});
  const Vec2 across = normalized(left - right);
  Polyline line = {right, left};
  const auto add = [&](Vec2 p) {
    const double at_m = dot(across, p - right);
    if (at_m > off_line_m && at_m < distance(right, left) - off_line_m &&
        std::abs(cross(across, p - right)) < off_line_m && std::ranges::find(line, p) == line.end())
      line.push_back(p);
  };
  for (const Polyline& cut : cuts) add(cut.front()), add(cut.back());
  add(snap_to_grid({section.reference.x, section.reference.y}));
  std::ranges::sort(line, {}, [&](Vec2 p) { return dot(across, p - right); });
  cuts.push_back(std::move(line));
}

}  // namespace

std::vector<Polyline> lane_cuts(const roadquery::Road& road, const std::vector<CrossSection>& strip,
                                const EndPoints& joints) {
  std::vector<Polyline> cuts;
  if (road.junction >= 0 || strip.size() < 2) return cuts;
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    visit_borders(road, i, [&](const LaneBorder& border) { add_border(border, joints, cuts); });
    if (i == 0) continue;
    const auto at = std::ranges::find(strip, road.sections[i].s, &CrossSection::s_m);
    if (at != strip.end()) add_across(*at, cuts);
  }
  // A joint has its line across the road in the border of the level.
  if (joints.start.empty()) add_across(strip.front(), cuts);
  if (joints.end.empty()) add_across(strip.back(), cuts);
  return cuts;
}

std::vector<double> lane_borders_at(const roadquery::Road& road, bool at_end) {
  std::vector<double> borders;
  if (road.sections.empty() || road.junction >= 0) return borders;
  const double s = at_end ? road.length - end_rounding_m : 0.0;
  visit_borders(road, at_end ? road.sections.size() - 1 : 0, [&](const LaneBorder& border) {
    if (border.is_between_lanes(s)) borders.push_back(border.t_at(s));
  });
  std::ranges::sort(borders);
  return borders;
}

}  // namespace orthodrive::scene
