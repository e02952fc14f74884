// SPDX-License-Identifier: Apache-2.0
#pragma once
// The steps of a road query: which surfaces lie over a point, and which of them are its level.

#include <array>
#include <span>

#include "roadquery/surface/blend.hpp"
#include "roadquery/tables/baked_surface.hpp"
#include "roadquery/tables/cell_index.hpp"

namespace roadquery {

inline constexpr double seam_m = 0.25;  ///< how far a surface goes on beyond the end of its road
inline constexpr double edge_rounding_m = 1e-6;

/// A surface under a point.
struct Found {
  std::uint32_t station;
  LinePlace line;
  SurfacePlace on;
  double inside_m;      ///< distance to the nearest of the road's edges and ends; negative: outside
  double along_rest_m;  ///< the point lies this far beyond the end of the road
  /// Where lanes with heights or OpenCRG files lie on the road (has_relief): on.z has them, and these are the slopes
  /// and the friction (NaN: the lane's).
  bool has_relief;
  double rise_along, rise_left, friction;
};

/// Lays lanes' heights, then the road's OpenCRG files on the surface that `found` has of it, at (x, y).
void lay_relief(const BakedRoads& roads, const Station& q, double x, double y, Found& found);

/// Whether a foot at u is the station's own: at the end it is the next one's, so that a point between two has one
/// answer wherever it came from.
inline bool holds(const Station& q, double u) {
  constexpr double tie_m = 1e-9;
  return u >= -q.half_m - tie_m && u < q.half_m - tie_m;
}

/// Fills in the rest of what `found` has of its station and line (and, where the station is turned, surface). False
/// when the point lies more than outside_m beside the surface; less than that the surface goes on level.
inline bool complete(const BakedRoads& roads, const Station& q, const LaneStretch& lanes, double x, double y,
                     double outside_m, Found& found) {
  constexpr double sideways_m = 0.25;  // the shape of a banked road moves points sideways by less
  if (std::abs(found.line.left_m) > lanes.reach_m + outside_m + sideways_m) return false;
  const double u = found.line.u, s = q.s + u, ds = s - lanes.s;
  if (q.turned == not_turned) surface_at_left(roads, q, u, found.line.left_m, found.on);
  const Pair edges = cubics_at(lanes.edges, ds);
  const double right_edge = edges[0], left_edge = edges[1];
  const double beside_m = std::min(left_edge - found.on.t, found.on.t - right_edge);
  if (beside_m < -outside_m) return false;
  found.inside_m = std::min(beside_m, std::min(s, lanes.length_m - s));
  if (found.along_rest_m > edge_rounding_m) found.inside_m = std::min(found.inside_m, -found.along_rest_m);
  if (beside_m < -edge_rounding_m)
    surface_at_t(roads, q, u, std::clamp(found.on.t, std::min(right_edge, left_edge), left_edge), found.on);
  found.has_relief = lanes.relief != 0;
  if (found.has_relief) lay_relief(roads, q, x, y, found);
  return true;
}

/// The surfaces under one point; what comes after so many is not looked at.
struct FoundList {
  static constexpr std::size_t most = 64;
  FoundList() {}  // NOLINT: the items are written before they are read; to clear 64 of them takes longer than a query
  union {
    std::array<Found, most> items;
  };
  std::size_t count = 0;

  [[nodiscard]] std::span<Found> all() { return {items.data(), count}; }
};

/// The foot of (x, y) among successive stations of a road, from found.station on. False where the foot lies beyond
/// their ends, but for the ends of the road itself, where along_rest_m says how far (at most the greater of seam_m and
/// outside_m), or where the point lies further than outside_m beside the surface.
[[nodiscard]] bool find_on(const BakedRoads& roads, const StationRange& range, double x, double y, int most_steps,
                           double outside_m, Found& found);

/// Where to begin with find_on().
struct Start {
  StationRange range;
  std::uint32_t station, lanes;
};
struct StartList {
  StartList() {}  // NOLINT: as FoundList
  union {
    std::array<Start, FoundList::most> items;
  };
  std::size_t count = 0;
};

/// The surfaces of a cell that (x, y) lies on, and those it lies beside or beyond as far as find_on allows: first where
/// to look, while their memory comes, then what is found there.
void find_starts(const BakedRoads& roads, const Cell& cell, double outside_m, StartList& starts);
void search_starts(const BakedRoads& roads, const StartList& starts, double x, double y, double outside_m,
                   FoundList& list);
/// The same of each station by itself, the ends of which count as ends of a road: for points that have no foot, or that
/// lie where the road's width jumps. `only_folded`: only surfaces that have the point beyond their centre of curvature.
void search_stations(const BakedRoads& roads, const Cell& cell, double x, double y, double outside_m, bool only_folded,
                     FoundList& list);
/// The companions of a station that (x, y), a point of the station's own surface, lies on.
void search_companions(const BakedRoads& roads, std::uint32_t station, double x, double y, FoundList& list);

/// Of the surfaces in the list those that make up the level nearest to z_hint (NaN: the highest one); empty when there
/// is none. The level goes by one of the roads that is_anchor names.
template <typename IsAnchor>
[[nodiscard]] std::span<Found> level_of(FoundList& list, double z_hint, const IsAnchor& is_anchor) {
  const std::span<Found> all = list.all();
  const bool is_highest = std::isnan(z_hint);
  const Found* nearest = nullptr;
  double least = 0.0;
  for (const Found& f : all) {
    const double distance = is_highest ? -f.on.z : std::abs(f.on.z - z_hint);
    if (is_anchor(f) && (nearest == nullptr || distance < least)) nearest = &f, least = distance;
  }
  if (nearest == nullptr) return {};
  const double level_z = nearest->on.z;
  auto end = std::remove_if(all.begin(), all.end(), [&](const Found& f) { return !is_same_level(f.on.z, level_z); });
  // What goes on beyond the end of its road gives way to any road.
  const auto is_on_seam = [](const Found& f) { return f.along_rest_m > edge_rounding_m; };
  if (!std::all_of(all.begin(), end, is_on_seam)) end = std::remove_if(all.begin(), end, is_on_seam);
  return {all.begin(), end};
}

}  // namespace roadquery
