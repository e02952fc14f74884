// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/bake_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "roadquery/surface/road_surface.hpp"
#include "roadquery/surface/shift_cubic.hpp"

namespace roadquery {
namespace {

constexpr std::size_t most_lane_records = 8'000'000;  // 500 MB: lanes times the places where one of them changes

/// Adds the cubic of `cubics` that holds at `inside`, in powers of (x - s); before the first one it is 0.
void add_cubic(const std::vector<Cubic>& cubics, double inside, double s, double sign, double (&sum)[4]) {
  const auto next =
      std::upper_bound(cubics.begin(), cubics.end(), inside, [](double v, const Cubic& c) { return v < c.s; });
  if (next == cubics.begin()) return;
  const Cubic& c = *(next - 1);
  double at_s[4];
  shift_cubic({c.a, c.b, c.c, c.d}, s - c.s, at_s);
  for (int i = 0; i < 4; ++i) sum[i] += sign * at_s[i];
}

BakedLane bake_lane(const Lane& lane, double s_in_section) {
  BakedLane baked;
  baked.id = lane.id;
  for (const LaneMaterial& m : lane.materials) {
    if (m.s_offset > s_in_section && &m != &lane.materials.front()) break;
    baked.surface = m.surface;
    baked.friction = static_cast<float>(m.friction), baked.roughness_m = static_cast<float>(m.roughness);
  }
  return baked;
}

/// Of a lane with heights, from s on.
BakedHeight bake_height(const Lane& lane, double s_in_section, double inside_in_section) {
  const LaneHeightAt at = lane_height_at(lane.heights, inside_in_section);
  const double back_m = s_in_section - inside_in_section;
  BakedHeight baked;
  for (int i = 0; i < 2; ++i) {
    baked.at[i] = static_cast<float>(at.value[i] + back_m * at.rise[i]);
    baked.rise[i] = static_cast<float>(at.rise[i]);
  }
  return baked;
}

/// The stretch from s on; `inside` lies within it, clear of the rounding of its ends.
void bake_stretch(const Road& road, const LaneSection& section, double s, double inside, BakedRoads& baked) {
  LaneStretch stretch;
  stretch.s = s;
  stretch.first = static_cast<std::uint32_t>(baked.lanes.size()) & 0x1fffffffu;
  add_cubic(road.lane_offset, inside, s, 1.0, stretch.center);
  const auto add_side = [&](const std::vector<Lane>& lanes, double sign, int side) {
    double edge[4];
    std::copy(std::begin(stretch.center), std::end(stretch.center), edge);
    for (const Lane& lane : lanes) {
      double width[4] = {};
      add_cubic(lane.width, inside - section.s, s - section.s, sign, width);
      for (int i = 0; i < 4; ++i) edge[i] += width[i];
      BakedLane one = bake_lane(lane, inside - section.s);
      std::copy(std::begin(edge), std::end(edge), one.outer);
      baked.lanes.push_back(one);
      if (lane.heights.empty()) continue;
      stretch.relief |= relief_lanes;
      baked.heights.resize(baked.lanes.size());
      baked.heights.back() = bake_height(lane, s - section.s, inside - section.s);
    }
    for (int i = 0; i < 4; ++i) stretch.edges[i][side] = edge[i];
  };
  add_side(section.left, 1.0, 1);
  add_side(section.right, -1.0, 0);
  constexpr std::size_t most_lanes_beside = 65535;
  if (section.left.size() > most_lanes_beside || section.right.size() > most_lanes_beside ||
      baked.lanes.size() > most_lane_records)
    throw std::runtime_error("road " + std::to_string(road.id) + " has too many lanes");
  stretch.left_count = static_cast<std::uint16_t>(section.left.size());
  stretch.right_count = static_cast<std::uint16_t>(section.right.size());
  const std::span<const BakedLane> lanes = std::span<const BakedLane>(baked.lanes).subspan(stretch.first);
  stretch.one_material = !lanes.empty() && std::all_of(lanes.begin(), lanes.end(), [&](const BakedLane& lane) {
    return lane.surface == lanes.front().surface && lane.friction == lanes.front().friction &&
           lane.roughness_m == lanes.front().roughness_m;
  });
  baked.stretches.push_back(stretch);
}

/// A cubic of t as the row of `cubics` has it at t, in powers of (t - origin).
void row_cubic(std::span<const ShapeCubic> row, double t, double origin, double (&at_origin)[4]) {
  const auto next = std::upper_bound(row.begin(), row.end(), t, [](double v, const ShapeCubic& q) { return v < q.t; });
  const ShapeCubic& q = *(next == row.begin() ? next : next - 1);
  shift_cubic({q.a, q.b, q.c, q.d}, origin - q.t, at_origin);
}

/// The pieces between a row and the next one (empty: none follows).
ShapeRow bake_row(std::span<const ShapeCubic> row, std::span<const ShapeCubic> next, BakedRoads& baked) {
  std::vector<double> begins;
  begins.reserve(row.size());
  for (const ShapeCubic& q : row) begins.push_back(q.t);
  for (const ShapeCubic& q : next) begins.push_back(q.t);
  std::sort(begins.begin(), begins.end());
  begins.erase(std::unique(begins.begin(), begins.end()), begins.end());
  const double length = next.empty() ? 1.0 : next.front().s - row.front().s;
  ShapeRow result{row.front().s, static_cast<std::uint32_t>(baked.shapes.size())};
  bool flat = true;
  for (std::size_t i = 0; i < begins.size(); ++i) {
    ShapePiece piece;
    piece.s = row.front().s;
    piece.begin = static_cast<float>(begins[i]);
    // The nearer end of the piece: a crown's right half begins far outside of the road.
    const bool from_end = i + 1 < begins.size() && std::abs(begins[i + 1]) < std::abs(begins[i]);
    const double origin = begins[from_end ? i + 1 : i];
    piece.origin = static_cast<float>(origin);
    double here[4], there[4];
    row_cubic(row, begins[i], piece.origin, here);
    row_cubic(next.empty() ? row : next, begins[i], piece.origin, there);
    for (int k = 0; k < 4; ++k) {
      piece.value[k / 2][k % 2] = static_cast<float>(here[k]);
      piece.slope[k / 2][k % 2] = static_cast<float>((there[k] - here[k]) / length);
      flat = flat && piece.value[k / 2][k % 2] == 0.0F && piece.slope[k / 2][k % 2] == 0.0F;
    }
    baked.shapes.push_back(piece);
  }
  if (flat || begins.size() > 65535) {
    if (!flat) throw std::runtime_error("a row of <shape> has too many cubics");
    baked.shapes.resize(result.first);
  } else {
    result.count = static_cast<std::uint16_t>(begins.size());
  }
  return result;
}

}  // namespace

void bake_lanes(const Road& road, BakedRoads& baked) {
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    const LaneSection& section = road.sections[i];
    const double begin = i == 0 ? std::min(0.0, section.s) : section.s;
    const double end = i + 1 < road.sections.size() ? road.sections[i + 1].s : road.length;
    std::vector<double> starts = {begin};
    const auto add = [&](double s) {
      if (s > begin && s < end) starts.push_back(s);
    };
    add(section.s);
    for (const Cubic& c : road.lane_offset) add(c.s);
    for (const auto* side : {&section.left, &section.right}) {
      for (const Lane& lane : *side) {
        for (const Cubic& c : lane.width) add(section.s + c.s);
        for (const LaneMaterial& m : lane.materials) add(section.s + m.s_offset);
        for (const LaneHeight& h : lane.heights) add(section.s + h.s_offset);
      }
    }
    std::sort(starts.begin(), starts.end());
    starts.erase(std::unique(starts.begin(), starts.end()), starts.end());
    for (std::size_t k = 0; k < starts.size(); ++k)
      bake_stretch(road, section, starts[k], 0.5 * (starts[k] + (k + 1 < starts.size() ? starts[k + 1] : end)), baked);
  }
}

std::vector<ShapeRow> bake_shapes(const Road& road, BakedRoads& baked) {
  std::vector<ShapeRow> rows;
  const std::span<const ShapeCubic> all = road.shape;
  const auto row_end = [&](std::size_t first) {
    std::size_t end = first;
    while (end < all.size() && all[end].s == all[first].s) ++end;
    return end;
  };
  for (std::size_t first = 0; first < all.size();) {
    const std::size_t next = row_end(first), after = next < all.size() ? row_end(next) : next;
    rows.push_back(bake_row(all.subspan(first, next - first), all.subspan(next, after - next), baked));
    first = next;
  }
  return rows;
}

}  // namespace roadquery
