// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/plan/plan_index.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive::synth {
namespace {
/// Of the surface of a piece.
Box2 box_of(const PlannedRoad& road, const Stretch& piece) {
  constexpr double step_m = 4.0, sagitta_m = 1.0;  // arcs of a radius of 2 m and more between samples
  double reach_m = 0.0;
  Ring line;
  const int count = std::max(1, static_cast<int>(std::ceil((piece.s_end_m - piece.s_begin_m) / step_m)));
  for (int i = 0; i <= count; ++i) {
    const double s = piece.s_begin_m + (piece.s_end_m - piece.s_begin_m) * i / count;
    line.push_back(evaluate(road.alignment, s).p);
    reach_m = std::max(reach_m, 0.5 * road.width_at(s));
  }
  return bounds_of(line).grown(reach_m + sagitta_m);
}
}  // namespace

PlanIndex::PlanIndex(const SitePlan& plan) {
  constexpr double piece_m = 64.0;
  std::vector<Box2> piece_boxes, area_boxes;
  for (std::size_t r = 0; r < plan.roads.size(); ++r) {
    const PlannedRoad& road = plan.roads[r];
    const double length_m = road.alignment.length_m;
    const int count = road.alignment.closed ? 1 : std::max(1, static_cast<int>(std::ceil(length_m / piece_m)));
    for (int i = 0; i < count; ++i) {
      pieces_.push_back({r, length_m * i / count, i + 1 == count ? length_m : length_m * (i + 1) / count});
      piece_boxes.push_back(box_of(road, pieces_.back()));
    }
  }
  area_boxes.reserve(plan.areas.size());
  for (const Area& area : plan.areas) area_boxes.push_back(bounds_of(area.polygon.outer));
  piece_index_ = SpatialIndex(piece_boxes), area_index_ = SpatialIndex(area_boxes);
}

std::vector<Stretch> PlanIndex::stretches(const Box2& box) const {
  std::vector<Stretch> found;
  for (const std::uint32_t i : piece_index_.touching(box)) {
    const Stretch& piece = pieces_[i];
    if (!found.empty() && found.back().road == piece.road && found.back().s_end_m == piece.s_begin_m)
      found.back().s_end_m = piece.s_end_m;
    else
      found.push_back(piece);
  }
  return found;
}

std::vector<std::size_t> PlanIndex::areas(const Box2& box) const {
  const std::vector<std::uint32_t> found = area_index_.touching(box);
  return {found.begin(), found.end()};
}

}  // namespace orthodrive::synth
