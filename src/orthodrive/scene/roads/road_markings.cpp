// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_markings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "roadquery/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double max_piece_m = 5.0, chord_error_m = 0.01;
constexpr double min_width_m = 0.02;  // of a lane whose border is painted: where lanes begin there are two lines on one

/// A line along a road: the border of a lane, moved by `shift_m` to the left.
struct MarkLine {
  const roadquery::Road& road;
  const roadquery::LaneSection& section;
  int lane_id = 0;
  double shift_m = 0.0, width_m = 0.12;

  [[nodiscard]] double border_t(double s) const {
    double t = roadquery::evaluate(road.lane_offset, s);
    const bool left = lane_id > 0;
    const auto& lanes = left ? section.left : section.right;
    for (std::size_t i = 0; i < static_cast<std::size_t>(std::abs(lane_id)) && i < lanes.size(); ++i)
      t += (left ? 1.0 : -1.0) * roadquery::lane_width(lanes[i], s - section.s);
    return t;
  }
  /// Right and left end of the line's cross section.
  [[nodiscard]] std::array<Vec2, 2> cut(double s) const {
    const double t = border_t(s) + shift_m;
    const auto at = [&](double place) {
      const auto p = roadquery::surface_point(road, s, place);
      return Vec2{p.x, p.y};
    };
    return {at(t - 0.5 * width_m), at(t + 0.5 * width_m)};
  }
};

void add_stroke(const MarkLine& line, double from, double to, std::vector<MarkingPiece>& pieces) {
  double s = from;
  auto start = line.cut(s);
  while (s < to - 1e-6) {
    const double bend = std::max(std::abs(roadquery::reference_point(line.road, s).curvature),
                                 std::abs(roadquery::reference_point(line.road, std::min(to, s + 1.0)).curvature));
    // The sagitta of a chord is length^2 / (8 radius); lines beside the reference line bend about as much.
    const double step_m = std::clamp(std::sqrt(8.0 * chord_error_m / std::max(bend, 1e-6)), 0.25, max_piece_m);
    const double next = to - s < 1.2 * step_m ? to : s + step_m;
    const auto end = line.cut(next);
    pieces.push_back({start[0], end[0], end[1], start[1]});
    s = next;
    start = end;
  }
}

double lane_width_between(const roadquery::Lane& lane, double from, double to) {
  return std::min(roadquery::lane_width(lane, from), roadquery::lane_width(lane, to));
}

/// The marks of one lane, each from its offset to that of the next.
void add_lane_marks(const roadquery::Road& road, const roadquery::LaneSection& section, double section_end,
                    const roadquery::Lane& lane, bool outermost, std::vector<MarkingPiece>& pieces) {
  for (std::size_t i = 0; i < lane.marks.size(); ++i) {
    const roadquery::RoadMark& mark = lane.marks[i];
    const bool broken = mark.type == "broken";
    if ((!broken && mark.type != "solid") || !(mark.width > 0.0)) continue;
    const double from = section.s + mark.s_offset;
    const double to = i + 1 < lane.marks.size() ? section.s + lane.marks[i + 1].s_offset : section_end;
    const double inwards = outermost ? 0.5 * mark.width : 0.0;
    const MarkLine line{road, section, lane.id, lane.id > 0 ? -inwards : inwards, mark.width};
    const DashPattern pattern = dash_pattern(road);
    const double period_m = pattern.stroke_m + pattern.gap_m;
    const auto stroke = [&](double a, double b) {
      const bool narrow =
          lane.id != 0 && lane_width_between(lane, a - section.s, b - section.s) < min_width_m + 2.0 * inwards;
      if (b > a && !narrow) add_stroke(line, a, b, pieces);
    };
    if (!broken) {
      stroke(from, to);
      continue;
    }
    for (double s = std::floor(from / period_m) * period_m; s < to; s += period_m)
      stroke(std::max(from, s), std::min(to, s + pattern.stroke_m));
  }
}

}  // namespace

DashPattern dash_pattern(const roadquery::Road& road) {
  constexpr double kmh = 1.0 / 3.6;
  const bool fast_class = road.highway.starts_with("motorway") || road.highway.starts_with("trunk");
  const double speed_mps = road.speed_limit_mps > 0.0 ? road.speed_limit_mps : (fast_class ? 120.0 : 50.0) * kmh;
  if (speed_mps <= 60.5 * kmh) return {3.0, 6.0};
  if (speed_mps <= 100.5 * kmh) return {4.0, 8.0};
  return {6.0, 12.0};
}

std::vector<MarkingPiece> road_markings(const roadquery::Road& road) {
  std::vector<MarkingPiece> pieces;
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    const roadquery::LaneSection& section = road.sections[i];
    const double end = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
    // Where all lanes are on one side the centre line is the edge of the road.
    add_lane_marks(road, section, end, section.center, false, pieces);
    for (const auto* side : {&section.left, &section.right})
      for (std::size_t k = 0; k < side->size(); ++k)
        add_lane_marks(road, section, end, (*side)[k], k + 1 == side->size(), pieces);
  }
  return pieces;
}

}  // namespace orthodrive::scene
