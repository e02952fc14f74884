// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/overlaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/tables/baked_surface.hpp"
#include "roadquery/tables/surface_search.hpp"

namespace roadquery {
namespace {

constexpr double box_rounding_m = 0.02;  // more than an edge bends between two corners of a box

/// A rectangle in a station's frame, at first empty.
struct Part {
  double along_min = 1e30, along_max = -1e30, left_min = 1e30, left_max = -1e30;

  void add(double along, double left) {
    along_min = std::min(along_min, along), along_max = std::max(along_max, along);
    left_min = std::min(left_min, left), left_max = std::max(left_max, left);
  }
  [[nodiscard]] bool empty() const { return left_min > left_max; }
};

/// What of a ring lies beside a station. Sutherland and Hodgman's clipping (1974) by the two ends of the station.
Part beside(const StationBox& box, std::span<const FramePoint> ring) {
  Part part;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const FramePoint &p = ring[i], &next = ring[i + 1 < ring.size() ? i + 1 : 0];
    if (p.along >= box.along_min && p.along <= box.along_max) part.add(p.along, p.left);
    for (const double end : {box.along_min, box.along_max})
      if ((p.along < end) != (next.along < end))
        part.add(end, p.left + (end - p.along) / (next.along - p.along) * (next.left - p.left));
  }
  return part;
}

/// Of the box of b beside a.
Part beside(const Station& a, const StationBox& box_a, const Station& b, const StationBox& box_b) {
  std::array<FramePoint, 4> corners;
  std::size_t count = 0;
  for (const auto& [along, left] :
       {std::pair{box_b.along_min, box_b.left_min}, std::pair{box_b.along_max, box_b.left_min},
        std::pair{box_b.along_max, box_b.left_max}, std::pair{box_b.along_min, box_b.left_max}})
    corners[count++] =
        in_frame(a, b.x + along * b.cos_hdg - left * b.sin_hdg, b.y + along * b.sin_hdg + left * b.cos_hdg);
  return beside(box_a, corners);
}

/// Largest part of the width of a station that no other surface is known to touch.
struct FreeWidth {
  double right = 0.0, left = 0.0;
  void take_away(const Part& taken) {
    if (taken.empty() || taken.left_max < right || taken.left_min > left) return;
    if (taken.left_min - right > left - taken.left_max)
      left = taken.left_min;
    else
      right = taken.left_max;
  }
};

/// Lowest and highest point of a station's surface, roughly.
std::array<double, 2> heights(const BakedRoads& roads, const Station& q, const StationBox& box) {
  double low = q.z, high = q.z;
  for (const double u : {-static_cast<double>(q.half_m), 0.0, static_cast<double>(q.half_m)}) {
    for (const double t : {box.left_min, box.left_max}) {
      SurfacePlace place;
      surface_at_t(roads, q, u, t, place);
      const double z = place.z;
      low = std::min(low, z), high = std::max(high, z);
    }
  }
  return {low, high};
}

struct Extent {
  StationBox box;
  std::array<double, 2> z = {1e30, -1e30};  // an unusable station touches none
};

std::vector<Extent> extents_of(const BakedRoads& roads) {
  std::vector<Extent> extents;
  extents.reserve(roads.stations.size());
  for (const Station& q : roads.stations) {
    extents.emplace_back();
    if (q.shape_count == unusable_station) continue;
    extents.back().box = station_box(roads, q);
    extents.back().z = heights(roads, q, extents.back().box);
  }
  return extents;
}

/// The part of station i that station k lies over; empty when there is none.
Part overlap(const BakedRoads& roads, const std::vector<Extent>& extents, std::uint32_t i, std::uint32_t k,
             double level_m) {
  const Station &a = roads.stations[i], &b = roads.stations[k];
  const Extent &one = extents[i], &other = extents[k];
  if (one.z[0] > other.z[1] + level_m || other.z[0] > one.z[1] + level_m) return {};
  const LaneStretch &lanes_a = roads.stretches[a.lanes], &lanes_b = roads.stretches[b.lanes];
  const double reach = static_cast<double>(lanes_a.reach_m) + lanes_b.reach_m + 2.0 * box_rounding_m;
  if (lanes_a.road == lanes_b.road && std::abs(a.s - b.s) < reach) return {};  // neighbours, and folds of a bend
  const double far = 1.5 * (reach + a.half_m + b.half_m);
  if (std::abs(a.x - b.x) > far || std::abs(a.y - b.y) > far) return {};
  const Part taken = beside(a, one.box, b, other.box);
  if (taken.empty() || taken.left_max < one.box.left_min || taken.left_min > one.box.left_max) return {};
  return beside(b, other.box, a, one.box).empty() ? Part{} : taken;
}

/// Grows the companion by a part, and by what search_companions() may find beyond a road's end.
void grow(Companion& companion, const Part& part) {
  constexpr double beyond_m = seam_m + box_rounding_m;
  const auto down = [](double m) { return std::floor((m - beyond_m) / static_cast<double>(companion_step_m)); };
  const auto up = [](double m) { return std::ceil((m + beyond_m) / static_cast<double>(companion_step_m)); };
  const auto keep = [](double steps) { return static_cast<std::int8_t>(std::clamp(steps, -128.0, 127.0)); };
  companion.along_min = std::min(companion.along_min, keep(down(part.along_min)));
  companion.along_max = std::max(companion.along_max, keep(up(part.along_max)));
  companion.left_min = std::min(companion.left_min, keep(down(part.left_min)));
  companion.left_max = std::max(companion.left_max, keep(up(part.left_max)));
}

/// Largest distance between the line and the tangent of its middle, and of the surface that tilts with it.
double bend_of(const BakedRoads& roads, const Station& q) {
  double bend_m = 0.0;
  for (const double u : {-static_cast<double>(q.half_m), static_cast<double>(q.half_m)}) {
    const LinePolynomial line = line_at(q, u);
    const double speed2 = line.tangent[0] * line.tangent[0] + line.tangent[1] * line.tangent[1];
    const double tilt = 1.0 - std::abs(line.tangent[0]) / std::sqrt(speed2);
    const AheadRange ahead = ahead_range(roads, q, u);
    const double aside = std::max(-ahead.min_m, ahead.max_m) * std::abs(line.tangent[1]) / std::sqrt(speed2);
    bend_m = std::max(bend_m, std::abs(line.position[1]) + tilt * roads.stretches[q.lanes].reach_m + aside);
  }
  return bend_m;
}

void keep_free_width(const BakedRoads& roads, const FreeWidth& free, Station& q) {
  const auto steps = [](double t) { return static_cast<std::int8_t>(std::clamp(t, -127.0, 127.0)); };
  const double bend_m = bend_of(roads, q);
  q.free_right = steps(std::ceil((free.right + bend_m) / free_step_m));
  q.free_left = steps(std::floor((free.left - bend_m) / free_step_m));
}

}  // namespace

AheadRange ahead_range(const BakedRoads& roads, const Station& q, double u) {
  AheadRange range;
  if (q.turned == not_turned) return range;
  constexpr int parts = 4;  // across the lanes: between two a lateral profile bends by little
  const LaneStretch& lanes = roads.stretches[q.lanes];
  const Pair edges = cubics_at(lanes.edges, q.s + u - lanes.s);
  for (int k = 0; k <= parts; ++k) {
    SurfacePlace place;
    surface_at_t(roads, q, u, edges[0] + (edges[1] - edges[0]) * k / parts, place);
    range.min_m = std::min(range.min_m, place.ahead_m), range.max_m = std::max(range.max_m, place.ahead_m);
  }
  return range;
}

StationBox station_box(const BakedRoads& roads, const Station& q) {
  const LaneStretch& lanes = roads.stretches[q.lanes];
  StationBox box{1e30, -1e30, 1e30, -1e30};
  for (const double part : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const double u = part * q.half_m, ds = q.s + u - lanes.s;
    const LinePolynomial line = line_at(q, u);
    const AheadRange ahead = ahead_range(roads, q, u);
    const Pair edges = cubics_at(lanes.edges, ds);
    for (const double ahead_m : {ahead.min_m, ahead.max_m})
      for (const double t : {0.0, edges[1], edges[0]}) {
        const FramePoint at = place_beside(line, {ahead_m, t});
        box.along_min = std::min(box.along_min, at.along), box.along_max = std::max(box.along_max, at.along);
        box.left_min = std::min(box.left_min, at.left), box.left_max = std::max(box.left_max, at.left);
      }
  }
  box.along_min -= box_rounding_m, box.left_min -= box_rounding_m;
  box.along_max += box_rounding_m, box.left_max += box_rounding_m;
  return box;
}

void find_overlaps(BakedRoads& roads, const RoadMap& map, const CellIndex& cells, double level_m) {
  const std::vector<Extent> extents = extents_of(roads);
  std::vector<FramePoint> ring;
  std::vector<std::uint32_t> near, junctions, seen_by(roads.stations.size(), no_index);
  roads.companion_begin.assign(1, 0);
  roads.deciding_junction.assign(roads.stations.size(), {});
  for (std::uint32_t i = 0; i < roads.stations.size(); ++i) {
    Station& q = roads.stations[i];
    near.clear();
    if (q.shape_count != unusable_station) cells.append_near(q, extents[i].box, i, seen_by, near);
    std::sort(near.begin(), near.end());
    FreeWidth free{extents[i].box.left_min, extents[i].box.left_max};
    for (const std::uint32_t k : near) {
      const Part part = overlap(roads, extents, i, k, level_m);
      if (part.empty()) continue;
      free.take_away(part);
      const bool goes_on = roads.companions.size() > roads.companion_begin.back() &&
                           roads.companions.back().range.last + 1 == k &&
                           roads.first_station[roads.road_of(roads.stations[k])] != k;
      if (!goes_on) roads.companions.push_back({.range = {k, k}});
      roads.companions.back().range.last = k;
      grow(roads.companions.back(), part);
    }
    junctions.clear();
    if (q.shape_count != unusable_station) cells.append_junctions(q, extents[i].box, junctions);
    for (const std::uint32_t junction : junctions) {
      ring.clear();
      for (const auto& [x, y] : surface_of(map.junctions[junction])->boundary) ring.push_back(in_frame(q, x, y));
      const Part part = beside(extents[i].box, ring);
      std::uint32_t& deciding = roads.deciding_junction[i].index;
      if (!part.empty()) deciding = deciding == no_index ? junction : one_of_several;
      free.take_away(part);
    }
    keep_free_width(roads, free, q);
    roads.companion_begin.push_back(static_cast<std::uint32_t>(roads.companions.size()));
  }
  roads.companions.shrink_to_fit();
}

}  // namespace roadquery
