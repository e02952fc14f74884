// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/surface_search.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/crg/road_crgs.hpp"

namespace roadquery {
namespace {

/// Beyond which end of the range a point lies.
enum class Beyond : std::uint8_t { none, kink, first, last };

/// The place of (x, y) on the station whose surface lies there, from one in the range on; clamped to the station's end
/// where it lies between two stations (a kink) or beyond the range. False when most_steps were not enough.
bool find_station(const BakedRoads& roads, const StationRange& range, double x, double y, int most_steps, Found& found,
                  Beyond& beyond) {
  std::uint32_t low = range.first, high = range.last;  // the foot is on these, as far as is known
  std::uint32_t& station = found.station;
  for (int i = 0; i < most_steps; ++i) {
    const Station& q = roads.stations[station];
    if (q.shape_count == unusable_station) return false;
    const double half = q.half_m;
    const FramePoint p = in_frame(q, x, y);
    double u = guess_u(q, p);
    if (q.turned == far_turned && !(std::abs(u) <= 1.25 * half + 0.5)) u = guess_turned_u(roads, q, p);
    if (std::isnan(u)) return false;  // of a place that is none, or a line that overflows
    if (std::abs(u) <= 1.25 * half + 0.5) {
      if (q.turned != not_turned)
        turned_foot(roads, q, p, u, found.line, found.on);
      else
        found.line = foot_on(q, p, u);
      u = found.line.u;
      beyond = Beyond::none;
      if (holds(q, u) || (std::abs(u) <= half && u > 0.0 && station == range.last)) return true;
    }
    const bool ahead = u > 0.0;
    if (ahead ? station >= high : station <= low) {
      found.line = place_at(q, ahead ? half : -half, p);
      if (q.turned != not_turned) lay_turned(roads, q, found.line, found.on);
      const bool is_end = ahead ? station == range.last : station == range.first;
      beyond = !is_end ? Beyond::kink : ahead ? Beyond::last : Beyond::first;
      return true;
    }
    const auto jump = static_cast<std::uint32_t>(std::min((std::abs(u) - half) / (2.0 * half), 1e6)) + 1;
    if (ahead) {
      low = station + 1;
      station = high - station > jump ? station + jump : high;
    } else {
      high = station - 1;
      station = station - low > jump ? station - jump : low;
    }
  }
  return false;
}

/// Two cache lines.
template <typename T>
void prefetch(const T& record) {
  static_assert(sizeof(T) == 128);
  const char* line = reinterpret_cast<const char*>(&record);  // NOLINT
  __builtin_prefetch(line), __builtin_prefetch(line + 64);
}

/// Whether the place lies so near to the centre of curvature, or beyond it, that Newton's method may find no foot.
bool is_folded(const Station& q, const LinePlace& place) {
  const LinePolynomial line = line_at(q, place.u);
  const double square = line.tangent[0] * line.tangent[0] + line.tangent[1] * line.tangent[1];
  const double turn = line.tangent[0] * line.bend[1] - line.tangent[1] * line.bend[0];
  return place.left_m * turn > 0.9 * square * std::sqrt(square);
}

/// Whether a point, in the station's frame and companion_step_m, may lie on the companion.
bool may_touch(const Companion& companion, float along, float left) {
  const auto within = [](float at, std::int8_t least, std::int8_t most) {
    return (at >= static_cast<float>(least) || least == -128) && (at <= static_cast<float>(most) || most == 127);
  };
  return within(along, companion.along_min, companion.along_max) &&
         within(left, companion.left_min, companion.left_max);
}

double slope_of(const double (&c)[4], double ds) { return c[1] + ds * (2.0 * c[2] + ds * 3.0 * c[3]); }

/// The lane at a place of a stretch if it has heights, else nullptr.
const BakedLane* raised_lane(const BakedRoads& roads, const LaneStretch& stretch, double s, double t) {
  const BakedLane* lane = lane_at(roads, stretch, s, t, edge_rounding_m);
  if (lane == nullptr || static_cast<std::size_t>(lane - roads.lanes.data()) >= roads.heights.size()) return nullptr;
  const BakedHeight& height = roads.heights[static_cast<std::size_t>(lane - roads.lanes.data())];
  const bool is_flat = height.at[0] == 0.0F && height.at[1] == 0.0F && height.rise[0] == 0.0F && height.rise[1] == 0.0F;
  return is_flat ? nullptr : lane;
}

/// As lane_height of road_surface.hpp.
void lay_lane(const BakedRoads& roads, const LaneStretch& stretch, const BakedLane& lane, const RoadPlace& place,
              LaidSurface& laid) {
  const auto index = static_cast<std::size_t>(&lane - roads.lanes.data());
  const std::size_t first = stretch.first;
  const BakedHeight& height = roads.heights[index];
  const double ds = place.s - stretch.s;
  const bool innermost = index == first || index == first + stretch.left_count;
  const double(&border)[4] = innermost ? stretch.center : (&lane - 1)->outer;
  const double inner = cubic_at(border, ds), width = cubic_at(lane.outer, ds) - inner;
  const double at_inner = height.at[0] + ds * height.rise[0], across = height.at[1] + ds * height.rise[1] - at_inner;
  const double rise = height.rise[0], rise_across = height.rise[1] - height.rise[0];
  const auto add = [&](double z, double dz_ds, double dz_dt) {
    laid.z += z;
    laid.rise_along += dz_ds * place.s_per_along + dz_dt * place.t_per_along;
    laid.rise_left += dz_ds * place.s_per_left + dz_dt * place.t_per_left;
  };
  if (width == 0.0) return add(at_inner, rise, 0.0);
  const double share = (place.t - inner) / width;
  const double inner_slope = slope_of(border, ds), width_slope = slope_of(lane.outer, ds) - inner_slope;
  const double share_slope = -(inner_slope + share * width_slope) / width;
  add(at_inner + share * across, rise + share * rise_across + share_slope * across, across / width);
}

}  // namespace

void lay_relief(const BakedRoads& roads, const Station& q, double x, double y, Found& found) {
  const LinePlace& line = found.line;
  const LaneStretch& lanes = roads.stretches[q.lanes];
  const BakedLane* raised =
      (lanes.relief & relief_lanes) != 0 ? raised_lane(roads, lanes, q.s + line.u, found.on.t) : nullptr;
  if (raised == nullptr && (lanes.relief & relief_crg) == 0) {
    found.has_relief = false;
    return;
  }
  const double inverse_speed = line.inverse_speed;
  RoadPlace place{q.s + line.u, found.on.t, x, y};
  place.cos_hdg = (q.cos_hdg * line.dx_du - q.sin_hdg * line.dy_du) * inverse_speed;
  place.sin_hdg = (q.sin_hdg * line.dx_du + q.cos_hdg * line.dy_du) * inverse_speed;
  const SectionTangents tangents = tangents_at(q, line, found.on, curvature_at(line));
  LaidSurface laid{found.on.z};
  if (const double area = tangents.area(); area > 0.0) {
    place.s_per_along = tangents.t_left / area, place.s_per_left = -tangents.t_forward / area;
    place.t_per_along = -tangents.s_left / area, place.t_per_left = tangents.s_forward / area;
    laid.rise_along = -tangents.normal_forward() / area, laid.rise_left = -tangents.normal_left() / area;
  }
  laid.friction = std::nan("");
  if (raised != nullptr) lay_lane(roads, lanes, *raised, place, laid);
  if ((lanes.relief & relief_crg) != 0) roads.crgs->lay(static_cast<int>(roads.road_of(q)), place, laid);
  found.on.z = laid.z, found.rise_along = laid.rise_along, found.rise_left = laid.rise_left;
  found.friction = laid.friction;
}

namespace {

/// find_on() without complete().
bool find_foot(const BakedRoads& roads, const StationRange& range, double x, double y, int most_steps, double outside_m,
               Found& found) {
  Beyond beyond = Beyond::none;
  if (!find_station(roads, range, x, y, most_steps, found, beyond)) return false;
  found.along_rest_m = 0.0;
  if (beyond == Beyond::none) return true;
  const double rest = std::abs(found.line.ahead_m);
  if (rest > std::max(outside_m, seam_m)) return false;
  if (beyond == Beyond::kink) return true;
  const StationRange road = roads.stations_of(roads.road_of(roads.stations[found.station]));
  const bool is_road_end = found.station == (beyond == Beyond::last ? road.last : road.first);
  if (!is_road_end && rest > edge_rounding_m) return false;
  found.along_rest_m = rest;
  return true;
}

bool complete(const BakedRoads& roads, double x, double y, double outside_m, Found& found) {
  const Station& q = roads.stations[found.station];
  return complete(roads, q, roads.stretches[q.lanes], x, y, outside_m, found);
}

/// Those of the list from `first` on have feet: completes them, and drops those that are not under the point. Feet
/// first, as each step of a foot waits for the one before it, and the feet of several surfaces do not wait for each
/// other.
void complete_all(const BakedRoads& roads, std::size_t first, double x, double y, double outside_m, FoundList& list) {
  std::size_t kept = first;
  for (std::size_t i = first; i < list.count; ++i) {
    if (!complete(roads, x, y, outside_m, list.items[i])) continue;
    if (kept != i) list.items[kept] = list.items[i];
    ++kept;
  }
  list.count = kept;
}

}  // namespace

bool find_on(const BakedRoads& roads, const StationRange& range, double x, double y, int most_steps, double outside_m,
             Found& found) {
  return find_foot(roads, range, x, y, most_steps, outside_m, found) && complete(roads, x, y, outside_m, found);
}

void find_starts(const BakedRoads& roads, const Cell& cell, double outside_m, StartList& starts) {
  const auto reach_m = static_cast<float>(std::max(outside_m, seam_m));
  starts.count = 0;
  for (const CellEntry& entry : cell.entries) {
    if (starts.count == starts.items.size()) break;
    Start& start = starts.items[starts.count];
    if (!may_touch(entry, cell.x, cell.y, reach_m, start.range, start.station)) continue;
    prefetch(roads.stations[start.station]), prefetch(roads.stretches[entry.lanes]);
    start.lanes = entry.lanes;
    ++starts.count;
  }
}

void search_starts(const BakedRoads& roads, const StartList& starts, double x, double y, double outside_m,
                   FoundList& list) {
  constexpr int most_steps = 24;
  const std::size_t first = list.count;
  for (std::size_t i = 0; i < starts.count; ++i) {
    const Start& start = starts.items[i];
    __builtin_prefetch(roads.shapes.data() + roads.stations[start.station].shapes);
    __builtin_prefetch(roads.lanes.data() + roads.stretches[start.lanes].first);
  }
  for (std::size_t i = 0; i < starts.count && list.count < FoundList::most; ++i) {
    Found& found = list.items[list.count];
    found.station = starts.items[i].station;
    if (find_foot(roads, starts.items[i].range, x, y, most_steps, outside_m, found)) ++list.count;
  }
  complete_all(roads, first, x, y, outside_m, list);
}

void search_stations(const BakedRoads& roads, const Cell& cell, double x, double y, double outside_m, bool only_folded,
                     FoundList& list) {
  const double reach_m = only_folded ? std::max(outside_m, seam_m) : outside_m;
  StationRange range;
  std::uint32_t start = 0;
  for (const CellEntry& entry : cell.entries) {
    if (!may_touch(entry, cell.x, cell.y, static_cast<float>(reach_m), range, start)) continue;
    for (std::uint32_t i = range.first; i <= range.last && list.count < FoundList::most; ++i) {
      const Station& q = roads.stations[i];
      const double half = q.half_m;
      const FramePoint p = in_frame(q, x, y);
      // Of 1 at the line and 0 at the centre of curvature. What is clearly not asked for is passed over.
      const double share = 1.0 - 2.0 * static_cast<double>(q.bend[0][1]) * p.left;
      const double guess = q.turned != not_turned ? guess_turned_u(roads, q, p) : guess_u(q, p);
      if (only_folded ? share > 0.6 : (std::abs(guess) - half) * std::max(share, 0.2) > 1.5 * reach_m) continue;
      Found& found = list.items[list.count];
      found.station = i;
      if (q.turned != not_turned)
        turned_foot(roads, q, p, std::clamp(guess, -half, half), found.line, found.on);
      else
        found.line = foot_on(q, p, std::clamp(guess, -half, half));
      found.line = place_at(q, std::clamp(found.line.u, -half, half), p);
      if (q.turned != not_turned) lay_turned(roads, q, found.line, found.on);
      found.along_rest_m = std::abs(found.line.ahead_m);
      if (only_folded && !is_folded(q, found.line)) continue;
      if (found.along_rest_m <= reach_m && complete(roads, q, roads.stretches[q.lanes], x, y, outside_m, found))
        ++list.count;
    }
  }
}

void search_companions(const BakedRoads& roads, std::uint32_t station, double x, double y, FoundList& list) {
  constexpr int most_steps = 24;
  const FramePoint p = in_frame(roads.stations[station], x, y);
  const float along = static_cast<float>(p.along) / companion_step_m,
              left = static_cast<float>(p.left) / companion_step_m;
  const std::size_t first = list.count;
  for (std::uint32_t i = roads.companion_begin[station]; i < roads.companion_begin[station + 1]; ++i) {
    if (list.count == FoundList::most) break;
    if (!may_touch(roads.companions[i], along, left)) continue;
    const StationRange& range = roads.companions[i].range;
    Found& found = list.items[list.count];
    found.station = range.first + (range.last - range.first) / 2;
    if (find_foot(roads, range, x, y, most_steps, edge_rounding_m, found)) ++list.count;
  }
  complete_all(roads, first, x, y, edge_rounding_m, list);
}

}  // namespace roadquery
