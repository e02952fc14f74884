// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_markings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/model/roads/highway_class.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double max_piece_m = 5.0, chord_error_m = 0.01;
constexpr double min_width_m = 0.02;  // of a lane whose border is painted: where lanes begin there are two lines on one

constexpr double least_period_m = 0.1;          // strokes that are closer look like one, whatever a damaged file says
constexpr double dot_m = 0.1, dot_gap_m = 1.1;  // Caltrans, Standard Plans 2018, A20A: dots of 4 inches every 4 feet

/// A line of a mark, as RoadMarkLine, with what the mark and the road give it.
struct PaintedLine {
  double stroke_m = 0.0, gap_m = 0.0;  ///< no gap: without an end
  double shift_m = 0.0, s_offset_m = 0.0, width_m = 0.0;
  LinearColor color = white_paint;
  bool is_single_stroke = false;
  bool goes_on = false;  ///< strokes count from the start of the road, over its lane sections and marks
};

/// `outwards`: 1 where what lies further out lies further left.
std::vector<PaintedLine> painted_lines(const roadquery::RoadMark& mark, const roadquery::Road& road, double outwards) {
  std::vector<PaintedLine> lines;
  lines.reserve(mark.lines.size());
  for (const roadquery::RoadMarkLine& line : mark.lines)
    lines.push_back({line.length, line.space, line.t_offset, line.s_offset, line.width > 0.0 ? line.width : mark.width,
                     paint_color(line.color.empty() ? mark.color : line.color), line.is_single_stroke});
  if (!lines.empty()) return lines;
  const DashPattern pattern = dash_pattern(road);
  const PaintedLine solid{.width_m = mark.width, .color = paint_color(mark.color), .goes_on = true};
  PaintedLine broken = solid, dots = solid;
  broken.stroke_m = pattern.stroke_m, broken.gap_m = pattern.gap_m;
  dots.stroke_m = dot_m, dots.gap_m = dot_gap_m, dots.width_m = dot_m;
  const auto pair = [&](PaintedLine inner, PaintedLine outer) {
    inner.shift_m = -outwards * mark.width, outer.shift_m = outwards * mark.width;
    return std::vector{inner, outer};
  };
  if (mark.type == "solid") return {solid};
  if (mark.type == "broken") return {broken};
  if (mark.type == "solid solid") return pair(solid, solid);
  if (mark.type == "solid broken") return pair(solid, broken);
  if (mark.type == "broken solid") return pair(broken, solid);
  if (mark.type == "broken broken") return pair(broken, broken);
  if (mark.type == "botts dots") return {dots};
  return {};
}

/// A line along a road: the border of a lane, moved by `shift_m` to the left.
struct MarkLine {
  const roadquery::Road& road;
  const roadquery::LaneSection& section;
  int lane_id = 0;
  double shift_m = 0.0, width_m = 0.12;
  LinearColor color;

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
    pieces.push_back({{start[0], end[0], end[1], start[1]}, line.color});
    s = next;
    start = end;
  }
}

double lane_width_between(const roadquery::Lane& lane, double from, double to) {
  return std::min(roadquery::lane_width(lane, from), roadquery::lane_width(lane, to));
}

template <typename Wide>
void add_line_strokes(const MarkLine& line, const PaintedLine& painted, double from, double to, const Wide& is_wide,
                      std::vector<MarkingPiece>& pieces) {
  const auto stroke = [&](double a, double b) {
    if (b > a && is_wide(a, b)) add_stroke(line, a, b, pieces);
  };
  const double begin = from + painted.s_offset_m, period_m = painted.stroke_m + painted.gap_m;
  if (painted.is_single_stroke) {
    stroke(std::max(from, begin), std::min(to, begin + painted.stroke_m));
  } else if (!(painted.gap_m > 0.0) || !(painted.stroke_m > 0.0) || period_m < least_period_m) {
    stroke(std::max(from, begin), to);
  } else {
    const double phase = painted.goes_on ? 0.0 : begin, first = std::max(from, begin);
    for (double s = phase + std::floor((first - phase) / period_m) * period_m; s < to; s += period_m)
      stroke(std::max(from, s), std::min(to, s + painted.stroke_m));
  }
}

/// The marks of one lane, each from its offset to that of the next.
void add_lane_marks(const roadquery::Road& road, const roadquery::LaneSection& section, double section_end,
                    const roadquery::Lane& lane, bool outermost, std::vector<MarkingPiece>& pieces) {
  for (std::size_t i = 0; i < lane.marks.size(); ++i) {
    const roadquery::RoadMark& mark = lane.marks[i];
    const double from = section.s + mark.s_offset;
    const double to = i + 1 < lane.marks.size() ? section.s + lane.marks[i + 1].s_offset : section_end;
    const double inwards = outermost ? 0.5 * mark.width : 0.0;
    for (const PaintedLine& painted : painted_lines(mark, road, lane.id > 0 ? 1.0 : -1.0)) {
      if (!(painted.width_m > 0.0)) continue;
      const MarkLine line{
          road, section, lane.id, painted.shift_m + (lane.id > 0 ? -inwards : inwards), painted.width_m, painted.color};
      const auto is_wide = [&](double a, double b) {
        return lane.id == 0 || lane_width_between(lane, a - section.s, b - section.s) >= min_width_m + 2.0 * inwards;
      };
      add_line_strokes(line, painted, from, to, is_wide, pieces);
    }
  }
}

}  // namespace

DashPattern dash_pattern(const roadquery::Road& road) {
  constexpr double kmh = 1.0 / 3.6;
  const bool fast_class = is_fast_class(road.highway);
  const double speed_mps = road.speed_limit_mps > 0.0 ? road.speed_limit_mps : (fast_class ? 120.0 : 50.0) * kmh;
  if (speed_mps <= 60.5 * kmh) return {3.0, 6.0};
  if (speed_mps <= 100.5 * kmh) return {4.0, 8.0};
  return {6.0, 12.0};
}

LinearColor paint_color(std::string_view name) {
  // As worn as the white; traffic yellow (RAL 1023) and the like beside it.
  if (name == "yellow") return {0.60F, 0.36F, 0.01F};
  if (name == "orange") return {0.60F, 0.17F, 0.01F};
  if (name == "red") return {0.40F, 0.03F, 0.02F};
  if (name == "green") return {0.03F, 0.22F, 0.07F};
  if (name == "blue") return {0.02F, 0.10F, 0.38F};
  if (name == "violet") return {0.20F, 0.04F, 0.30F};
  if (name == "black") return {0.02F, 0.02F, 0.02F};
  return white_paint;
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
