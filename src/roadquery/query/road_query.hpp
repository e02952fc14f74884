// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which road, and how high, is under a point? Made for tyre contact points that ask thousands of times a second.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "roadquery/crg/road_crgs.hpp"
#include "roadquery/surface/road_surface.hpp"
#include "roadquery/tables/cell_index.hpp"
#include "roadquery/tables/junction_index.hpp"

namespace roadquery {

struct Found;
struct FoundList;

/// A point of a road's surface.
struct Hit {
  int road = -1;  ///< index into RoadQuery::map().roads
  double s = 0.0, t = 0.0;
  double z = 0.0;                                  ///< of the blended surface where roads of one level overlap
  std::array<double, 3> normal = {0.0, 0.0, 1.0};  ///< unit, upwards
  int lane_id = 0;                                 ///< 0 when exactly on the edge of a road without lanes there
  double curvature = 0.0;                          ///< 1/m in plan of the line of constant t, positive = left turn
  SurfaceClass surface = SurfaceClass::asphalt;
  double friction = 1.0, roughness_m = 0.0;
  bool in_junction = false;  ///< on a junction's own surface (JunctionSurface)
};

/// The least of a Hit.
struct HeightHit {
  int road = -1;
  double z = 0.0;
  bool in_junction = false;
};

/// What find() fills in of a Hit besides z, road and in_junction.
enum HitPart : unsigned {
  hit_normal = 1,
  hit_position = 2,  ///< s, t, lane_id
  hit_curvature = 4,
  hit_material = 8,  ///< surface, friction, roughness_m
  hit_all = 15,
  /// Not a part: z and normal are those of the road that the hit names, not of what overlaps it, nor of a junction's
  /// own surface.
  hit_own = 16
};

/// Remembers where the last query of one moving point ended, so that the next one begins there. One a point; start with
/// Cursor{}.
struct Cursor {
  int road = -1;
  double s = 0.0;
  std::uint32_t station = no_index;  ///< of the baked roads; no_index: that at road, s
};

/// The surface near a point, for who draws it.
struct SurfaceSample {
  double z = 0.0;
  std::array<double, 3> normal = {0.0, 0.0, 1.0};
  /// Distance to the border of the road that the point lies deepest in; negative: outside. 1 mm between the roads of a
  /// junction with a surface of its own.
  double inside_m = 0.0;
};

/// A road's surface across the road: (x, y, z).
struct RoadSection {
  std::array<double, 3> left{}, right{}, reference{};
};

/// Finds the road under a point in baked tables (baked_road.hpp): a hash of cells lists the stations over a place.
/// find() is const, does not allocate, lock or call the system, and may be called from many threads, each with its own
/// cursors.
///
/// Where surfaces lie one above the other the one nearest to z_hint wins (NaN: the highest; of two equally near ones
/// the lower road index). Surfaces within 1.5 m of that one are the same level (overlapping roads of a junction): z and
/// normal are their mean, as blend.hpp weights it. The hit names the cursor's road while the point is inside its edges,
/// else the one it lies deepest in. Up to 0.25 m beyond the end of a road its surface goes on where nothing else is:
/// that closes the wedge between two roads that meet at a slight angle. Likewise inside a bend tighter than the road is
/// wide, beyond its centre, where (s, t) of the road are not one to one. OpenCRG files of the map (RoadMap::crgs) are
/// laid on their roads first.
class RoadQuery {
 public:
  /// Throws std::runtime_error for a map without bounds (see bake).
  explicit RoadQuery(RoadMap map);

  [[nodiscard]] const RoadMap& map() const { return map_; }
  [[nodiscard]] const BakedRoads& baked() const { return baked_; }
  /// Nothing when no road is under (x, y), or when one of them is not finite. A cursor whose surface lies within 1 m of
  /// z_hint makes the query coherent: one station is looked at instead of all nearby.
  /// `parts`: sum of HitPart, what of a hit is asked for; the rest keeps its defaults.
  [[nodiscard]] std::optional<Hit> find(double x, double y, double z_hint, Cursor& cursor,
                                        unsigned parts = hit_all) const {
    std::optional<Hit> hit(std::in_place);
    if (!find(x, y, z_hint, cursor, parts, *hit)) hit.reset();
    return hit;
  }
  /// The same into a fresh Hit of the caller's; false: nothing.
  [[nodiscard]] bool find(double x, double y, double z_hint, Cursor& cursor, unsigned parts, Hit& hit) const;
  /// What find() gives without any part, for less.
  [[nodiscard]] bool find_height(double x, double y, double z_hint, Cursor& cursor, HeightHit& hit) const;
  [[nodiscard]] std::optional<double> find_height(double x, double y, double z_hint, Cursor& cursor) const {
    HeightHit hit;
    return find_height(x, y, z_hint, cursor, hit) ? std::optional(hit.z) : std::nullopt;
  }
  /// find() for each of the points, each with its own cursor (all spans of one length).
  void find_batch(std::span<const std::array<double, 3>> points, std::span<Cursor> cursors,
                  std::span<std::optional<Hit>> hits) const;
  /// The surface at s (clamped to the road) and t of a road, whatever else lies there; nothing for roads without a
  /// plan, lanes or finite numbers there.
  [[nodiscard]] std::optional<Hit> at(std::size_t road, double s, double t) const;
  /// Points of a road's own cross section at s (clamped to the road), from the tables: both edges and the reference
  /// line. OpenCRG files do not count. Nothing where at() has nothing.
  [[nodiscard]] std::optional<RoadSection> section(std::size_t road, double s) const;
  /// As find() at the highest surface of the roads of a level, the others blended in: z and normal agree with a find()
  /// whose z_hint is that surface. Up to reach_m (at most a cell; 0: not at all) beyond all borders the surface of the
  /// nearest of the roads goes on level.
  [[nodiscard]] std::optional<SurfaceSample> sample(double x, double y, double reach_m,
                                                    const std::vector<bool>& is_on_level) const;

 private:
  struct Level;
  void search_place(const Cell& cell, double x, double y, FoundList& list) const;
  /// Whether the cursor's station is the answer; `crowded`: `here` is on it, and other surfaces lie near it.
  enum class Followed { no, alone, crowded };
  template <typename Answer>
  [[nodiscard]] Followed follow_cursor(double x, double y, double z_hint, Cursor& cursor, unsigned parts, Found& here,
                                       Answer& hit) const;
  template <typename Answer>
  [[nodiscard]] bool find_in_core(const StationJunction& junction, const Station& q, double x, double y, double z_hint,
                                  unsigned parts, Answer& hit) const;
  [[nodiscard]] bool find_among(const Found* followed, double x, double y, double z_hint, Cursor& cursor,
                                unsigned parts, Hit& hit) const;
  [[nodiscard]] Level search(double x, double y, double z_hint, const Found* followed, FoundList& list) const;
  [[nodiscard]] static Level with_junction(const JunctionOver& over, double z_hint, FoundList& list);
  [[nodiscard]] std::optional<Found> nearest_of_junction(std::uint32_t junction, double x, double y) const;
  [[nodiscard]] std::span<Found> nearest_beside(double x, double y, double reach_m,
                                                const std::vector<bool>& is_on_level, FoundList& list) const;
  [[nodiscard]] bool fill_level(const Level& level, double x, double y, unsigned parts, Cursor& cursor, Hit& hit) const;

  RoadMap map_;
  BakedRoads baked_;
  JunctionIndex junctions_;
  CellIndex cells_;
};

}  // namespace roadquery
